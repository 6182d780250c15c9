#pragma once
#include "optimize/minimize.h"
#include <algorithm>

namespace signorini::optimize {

/// Algorithm 1 of the paper: projected gradient steps with a quadratic regularisation. Each step minimises
/// the model J + ⟨g, δ⟩ + ω/2 ‖δ‖² over the bounds. With ρ = actual/predicted decrease, a step is accepted if
/// ρ ≥ 0.1, and ω becomes the curvature with which the model would have been exact, ω + 2 (predicted −
/// actual)/‖δ‖² (= ω (2 − ρ) without bounds), but at most ten times and at least a tenth of the old ω, and at
/// least twice after a rejection. A trial at which a solver fails is rejected; the search ends with that
/// failure only if no shorter step succeeds either.
class RegularisedSteps {
public:
  template <TwiceDifferentiable P>
  std::optional<Result<typename P::Vector>>
  advance(Dimensionless<P>& problem, State<Dimensionless<P>, RegularisedSteps>& state, const Options&) {
    constexpr double sufficient = 0.1, change = 10;
    auto& [u, objective, g] = state.current;
    for (bool failed = false;;) {
      typename P::Vector trial = u;
      trial.add(-1 / omega_, g);
      problem.project(trial);
      typename P::Vector delta = trial;
      delta.add(-1, u);
      const double squared = problem.inner(delta, delta);
      const double predicted = -problem.inner(g, delta) - omega_ / 2 * squared;
      if (!(predicted > rounding(objective)))
        return Result<typename P::Vector>{failed ? Stop::solver_failed : Stop::no_decrease};
      double value = std::numeric_limits<double>::quiet_NaN();
      try {
        value = problem.value(trial);
        failed = false;
      } catch (const SolverFailure&) {
        failed = true;
      }
      const double actual = objective - value;
      const bool accepted = actual >= sufficient * predicted; // false for NaN
      const double exact = omega_ + 2 * (predicted - actual) / squared, used = omega_;
      omega_ = std::isfinite(exact) ? std::clamp(exact, (accepted ? 1 / change : 2) * omega_, change * omega_)
                                    : change * omega_;
      if (!accepted)
        continue;
      g = problem.trial_gradient();
      problem.accept();
      u = std::move(trial);
      objective = value;
      state.iteration = {state.iteration.number + 1, objective, stationarity(problem, u, g),
                         problem.units().step / used};
      return std::nullopt;
    }
  }

  template <class Archive>
  void serialize(Archive& archive) {
    archive("omega", omega_);
  }

private:
  double omega_ = 1; ///< ω, at first the unit of curvature (units.h)
};

template <TwiceDifferentiable P, class Report, class Checkpointer = NoCheckpointer>
[[nodiscard]] Result<typename P::Vector> projected_gradient(P& problem, typename P::Vector u,
                                                            const Options& options, Report&& report,
                                                            Checkpointer&& keeper = {}) {
  return minimize(problem, std::move(u), options, RegularisedSteps(), report, keeper);
}

} // namespace signorini::optimize
