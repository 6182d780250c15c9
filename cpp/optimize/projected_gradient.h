#pragma once
#include "optimize/problem.h"
#include <algorithm>

namespace signorini::optimize {

/// Algorithm 1 of the seed: projected gradient steps, damped by a quadratic regularisation. Each step
/// minimises the model J + ⟨g, δ⟩ + ω/2 ‖δ‖² over the bounds. With ρ = actual/predicted decrease, a step is
/// taken if ρ ≥ 0.1, and ω becomes the curvature that would have made the model exact, ω + 2 (predicted −
/// actual)/‖δ‖² (= ω (2 − ρ) without bounds), but at most ten times and at least a tenth of what it was, and
/// at least twice after a rejection. A trial that a solver fails at is rejected; only if no shorter step
/// succeeds either does the failure end the search.
///
/// `report(iteration)` is told of the first guess and of each accepted iterate, which is then the problem's
/// current point. Interrupted from the problem ends the search with the last accepted iterate. Throws
/// SolverFailure if the objective or its gradient is not finite.
template <BoundedProblem P, class Report>
[[nodiscard]] Ending<typename P::Vector> projected_gradient(P& problem, typename P::Vector u, const Options& options,
                                      Report&& report) {
  constexpr double sufficient = 0.1, change = 10;
  problem.project(u);
  try {
    double objective = problem.value(u);
    typename P::Vector g = problem.trial_gradient();
    problem.accept();
    Iteration iteration{0, objective, stationarity(problem, u, g), 0};
    const double tolerance = options.tolerance * iteration.gradient_norm;
    double omega = norm(problem, g) / options.first_step;
    for (;;) {
      if (const auto end = reported(iteration, tolerance, options, report))
        return {*end};
      for (bool failed = false;;) {
        typename P::Vector trial = u;
        trial.add(-1 / omega, g);
        problem.project(trial);
        typename P::Vector delta = trial;
        delta.add(-1, u);
        const double squared = problem.inner(delta, delta);
        const double predicted = -problem.inner(g, delta) - omega / 2 * squared;
        if (!(predicted > rounding(objective)))
          return {failed ? Stop::solver_failed : Stop::no_decrease};
        double value = std::numeric_limits<double>::quiet_NaN();
        try {
          value = problem.value(trial);
          failed = false;
        } catch (const SolverFailure&) {
          failed = true;
        }
        const double actual = objective - value;
        const bool accepted = actual >= sufficient * predicted; // false for NaN
        const double exact = omega + 2 * (predicted - actual) / squared;
        const double used = omega;
        omega = std::isfinite(exact) ? std::clamp(exact, (accepted ? 1 / change : 2) * omega, change * omega)
                                     : change * omega;
        if (!accepted)
          continue;
        g = problem.trial_gradient();
        problem.accept();
        u = std::move(trial);
        objective = value;
        iteration = {iteration.number + 1, objective, stationarity(problem, u, g), 1 / used};
        break;
      }
    }
  } catch (const Interrupted&) {
    return {Stop::interrupted};
  }
}

} // namespace signorini::optimize
