#pragma once
#include "base/error.h"
#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <string>

/// Algorithms against a concept: they know neither PETSc nor dolfinx.
namespace signorini::optimize {

/// A smooth (or piecewise smooth) function on a Hilbert space with simple bounds.
template <class P>
concept BoundedProblem = requires(P problem, const typename P::Vector& u, typename P::Vector& w) {
  { problem.value(u) } -> std::convertible_to<double>;          // J(u); u becomes the trial
  { problem.accept() };                                         // the trial becomes the current point
  { problem.gradient() } -> std::same_as<typename P::Vector>;   // at the current point, Riesz representative by inner()
  { problem.inner(u, u) } -> std::convertible_to<double>;
  { problem.project(w) };                                       // onto the bounds, in the norm of inner()
  { w.add(1.0, u) };
};

enum class Stop { gradient_tolerance, iteration_limit, no_decrease, solver_failed, interrupted };

inline std::string name(Stop stop) {
  switch (stop) {
  case Stop::gradient_tolerance:
    return "gradient norm below tolerance";
  case Stop::iteration_limit:
    return "iteration limit";
  case Stop::no_decrease:
    return "no further decrease: the predicted one is below rounding (at a minimiser or a kink of J)";
  case Stop::solver_failed:
    return "solver failed in every trial step";
  case Stop::interrupted:
    return "interrupted";
  }
  return "unknown";
}

struct Options {
  int max_iterations = 1000;
  double tolerance = 1e-6; ///< of the stationarity measure, relative to the first
  double first_step = 1; ///< length of the first trial step
};

/// What an iteration did.
struct Iteration {
  int number = 0;
  double objective = 0;
  double gradient_norm = 0; ///< ‖u − P(u − g)‖; without bounds ‖g‖
  double step_length = 0;   ///< 1/ω of the accepted step; 0 in row 0
};

template <BoundedProblem P>
double norm(const P& problem, const typename P::Vector& u) {
  return std::sqrt(problem.inner(u, u));
}

/// Norm of u − P(u − g), which is zero exactly at stationary points.
template <BoundedProblem P>
double stationarity(const P& problem, const typename P::Vector& u, const typename P::Vector& g) {
  typename P::Vector step = u;
  step.add(-1, g);
  problem.project(step);
  step.add(-1, u);
  return norm(problem, step);
}

/// Algorithm 1 of the seed: projected gradient steps, damped by a quadratic regularisation. Each step minimises the model
/// J + ⟨g, δ⟩ + ω/2 ‖δ‖² over the bounds. With ρ = actual/predicted decrease, a step is taken if ρ ≥ 0.1, and ω becomes
/// the curvature that would have made the model exact, ω + 2 (predicted − actual)/‖δ‖² (= ω (2 − ρ) without bounds), but at
/// most ten times and at least a tenth of what it was, and at least twice after a rejection.
/// A trial that a solver fails at is rejected; only if no shorter step succeeds either does the failure end the search.
///
/// `report(iteration)` is told of the first guess and of each accepted iterate, which is then the problem's current point.
/// Interrupted from value() or gradient() ends the search with the last accepted iterate. Throws SolverFailure if the
/// objective or its gradient is not finite.
template <BoundedProblem P, class Report>
[[nodiscard]] Stop projected_gradient(P& problem, typename P::Vector u, const Options& options, Report&& report) {
  constexpr double sufficient = 0.1, change = 10;
  problem.project(u);
  try {
    double objective = problem.value(u);
    problem.accept();
    typename P::Vector g = problem.gradient();
    Iteration iteration{0, objective, stationarity(problem, u, g), 0};
    const double tolerance = options.tolerance * iteration.gradient_norm;
    double omega = norm(problem, g) / options.first_step;
    for (;;) {
      if (!std::isfinite(iteration.objective) || !std::isfinite(iteration.gradient_norm))
        throw SolverFailure("the objective or its gradient is not finite at iteration " +
                            std::to_string(iteration.number));
      report(iteration);
      if (!(iteration.gradient_norm > tolerance))
        return Stop::gradient_tolerance;
      if (iteration.number >= options.max_iterations)
        return Stop::iteration_limit;
      for (bool failed = false;;) {
        typename P::Vector trial = u;
        trial.add(-1 / omega, g);
        problem.project(trial);
        typename P::Vector delta = trial;
        delta.add(-1, u);
        const double squared = problem.inner(delta, delta);
        const double predicted = -problem.inner(g, delta) - omega / 2 * squared;
        // A decrease below the rounding of J itself cannot be told from none.
        if (!(predicted > 4 * std::numeric_limits<double>::epsilon() * std::abs(objective)))
          return failed ? Stop::solver_failed : Stop::no_decrease;
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
        problem.accept();
        u = std::move(trial);
        g = problem.gradient();
        objective = value;
        iteration = {iteration.number + 1, objective, stationarity(problem, u, g), 1 / used};
        break;
      }
    }
  } catch (const Interrupted&) {
    return Stop::interrupted;
  }
}

} // namespace signorini::optimize
