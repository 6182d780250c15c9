// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/minimize.h"
#include <algorithm>

namespace signorini::optimize {

/// Projected gradient steps with a quadratic regularisation, Algorithm 1 of the paper. Each step minimises
/// the model J + ⟨g, δ⟩ + ω/2 ‖δ‖² over the bounds. It is accepted if ρ, the ratio of actual to predicted
/// decrease, is sufficient. In either case ω becomes the curvature with which the model is exact, ω + 2
/// (predicted − actual)/‖δ‖² (= ω (2 − ρ) without bounds), within limits of its change. A trial at which a
/// solver fails is rejected; the search ends with that failure only if no shorter step succeeds.
template <TwiceDifferentiable P>
class ProjectedGradient {
public:
  explicit ProjectedGradient(const Options& options) : options_(options) {}

  /// Makes one iteration, as minimize() defines it. Returns the result if the search ends.
  std::optional<Result<typename P::Vector>> advance(P& problem, State<P, ProjectedGradient>& state) {
    const auto& [sufficient, omega_factor, after_rejection] = options_.gradient;
    auto& [u, objective, g] = state.current;
    for (bool failed = false;;) {
      typename P::Vector trial = u;
      trial.add(-1 / omega_, g);
      problem.project(trial);
      const typename P::Vector delta = difference(trial, u);
      const double squared = problem.inner(delta, delta);
      const double predicted = -problem.inner(g, delta) - omega_ / 2 * squared;
      if (!(predicted > options_.negligible(objective)))
        return Result<typename P::Vector>{failed ? Stop::solver_failed : Stop::no_decrease};
      const std::optional<double> value = attempt(problem, trial);
      failed = !value;
      const double actual = objective - value.value_or(nan);
      const bool accepted = actual >= sufficient * predicted; // false for NaN
      const double exact = omega_ + 2 * (predicted - actual) / squared, used = omega_;
      omega_ = std::isfinite(exact)
                   ? std::clamp(exact, (accepted ? 1 / omega_factor : after_rejection) * omega_,
                                omega_factor * omega_)
                   : omega_factor * omega_;
      if (!accepted)
        continue;
      g = problem.trial_gradient();
      problem.accept();
      u = std::move(trial);
      objective = *value;
      state.iteration = {state.iteration.number + 1, objective, stationarity(problem, u, g),
                         problem.units().step / used};
      return std::nullopt;
    }
  }

  /// Does nothing: no vectors are stored.
  void make_room() {}

  /// Takes over the regularisation ω of a search on another problem.
  void inherit(const ProjectedGradient& other, const auto&, const auto&) { omega_ = other.omega_; }

  template <class Archive>
  void serialize(Archive& archive) {
    archive("omega", omega_);
  }

private:
  Options options_;
  double omega_ = 1; ///< ω; initially the unit of curvature (minimize.h)
};

} // namespace signorini::optimize
