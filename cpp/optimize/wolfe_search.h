// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/options.h"
#include "optimize/unknowns.h"

namespace signorini::optimize {

template <Differentiable P>
struct Search {
  std::optional<Iterate<P>> found; ///< the accepted trial, also the problem's
  double length = 0;               ///< t
  double promised = 0;             ///< −slope/2, of a direction with a minimum at t = 1
  bool solver_failed = false;      ///< in the last trial
};

/// Weak-Wolfe search by bisection and doubling (Lewis, Overton 2013), here along the arc t ↦ P(u + t d) and
/// from t = 1. It asks for sufficient decrease and for a slope above a part of the first, negative one, never
/// for a small one, so that it ends beyond a kink where there is no small slope. `d` must be tangential. A
/// trial at which a solver fails counts as too long.
template <Differentiable P>
[[nodiscard]] Search<P> weak_wolfe_search(P& problem, const Iterate<P>& from, const typename P::Vector& d,
                                          const Options& options) {
  const auto& [sufficient, flatter] = options.wolfe;
  const double slope = problem.inner(from.g, d), least = options.negligible(from.objective);
  Search<P> search;
  search.promised = -slope / 2;
  double low = 0, high = std::numeric_limits<double>::infinity();
  bool collapsed = false;
  for (double t = 1; -slope * t > least;) {
    typename P::Vector trial = from.u;
    trial.add(t, d);
    problem.project(trial);
    const std::optional<double> value = attempt(problem, trial);
    search.solver_failed = !value;
    const double decrease = from.objective - value.value_or(nan);
    const auto tangent = [&] { // the decrease of J's tangent
      return problem.bounded() ? -problem.inner(from.g, difference(trial, from.u)) : -slope * t;
    };
    if (decrease > 0 && decrease >= sufficient * tangent()) {
      typename P::Vector g = problem.trial_gradient();
      const bool steep = problem.inner(g, tangential(problem, trial, d)) < flatter * slope; // false for NaN
      if (!steep || collapsed) {
        search.found.emplace(std::move(trial), *value, std::move(g));
        search.length = t;
        return search;
      }
      low = t;
    } else if (collapsed) {
      return search;
    } else {
      high = t;
    }
    collapsed = low > 0 && -slope * (high - low) <= least;
    t = collapsed ? low : std::isfinite(high) ? (low + high) / 2 : 2 * low;
  }
  return search;
}

} // namespace signorini::optimize
