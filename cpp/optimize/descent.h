#pragma once
#include "optimize/problem.h"
#include <optional>

namespace signorini::optimize {

/// A point with what is known there.
template <BoundedProblem P>
struct Iterate {
  typename P::Vector u;
  double objective;
  typename P::Vector g;
};

/// What of d the bounds let u move along: its projection onto the tangent cone at u.
template <BoundedProblem P>
typename P::Vector tangential(const P& problem, const typename P::Vector& u, const typename P::Vector& d) {
  typename P::Vector along = d;
  problem.hold(along, u, d);
  return along;
}

template <BoundedProblem P>
struct Search {
  std::optional<Iterate<P>> found; ///< then it is the problem's trial
  double length = 0;               ///< t
  bool solver_failed = false;      ///< in the last trial
};

/// Weak-Wolfe search by bisection and doubling (Lewis, Overton 2013), here along the arc t ↦ P(u + t d) and
/// from t = 1. It asks for a sufficient decrease and for a slope that has become flatter, never for a small
/// one, so that it ends beyond a kink where there is no small one. `d` must be tangential. A trial that a
/// solver fails at is too far.
template <BoundedProblem P>
[[nodiscard]] Search<P> weak_wolfe_search(P& problem, const Iterate<P>& from, const typename P::Vector& d) {
  constexpr double sufficient = 1e-4, flatter = 0.9;
  const double slope = problem.inner(from.g, d), least = rounding(from.objective);
  Search<P> search;
  double low = 0, high = std::numeric_limits<double>::infinity();
  bool collapsed = false;
  for (double t = 1; -slope * t > least;) {
    typename P::Vector trial = from.u;
    trial.add(t, d);
    problem.project(trial);
    typename P::Vector step = trial;
    step.add(-1, from.u);
    double value = std::numeric_limits<double>::quiet_NaN();
    search.solver_failed = false;
    try {
      value = problem.value(trial);
    } catch (const SolverFailure&) {
      search.solver_failed = true;
    }
    const double decrease = from.objective - value;
    if (decrease > 0 && decrease >= -sufficient * problem.inner(from.g, step)) {
      typename P::Vector g = problem.trial_gradient();
      const bool steep = problem.inner(g, tangential(problem, trial, d)) < flatter * slope; // false for NaN
      if (!steep || collapsed) {
        search.found.emplace(std::move(trial), value, std::move(g));
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

/// Descent along the directions of `method`, which must be downhill. Where there is no way down one of them
/// it is asked to start afresh with the steepest, and the search ends where that leads nowhere either.
///
/// Of `method`: direction(problem, at) is tangential and as long as the first trial step is to be;
/// learn(problem, from, to, t) tells what t of it led to; restart() is false if the last direction was the
/// steepest. `report(iteration)` is told of the first guess and of each accepted iterate, which is then the
/// problem's current point. Interrupted from the problem ends the search with the last accepted iterate.
/// Throws SolverFailure if the objective or its gradient is not finite.
template <BoundedProblem P, class Method, class Report>
[[nodiscard]] Stop descend(P& problem, typename P::Vector u, const Options& options, Method method,
                           Report&& report) {
  problem.project(u);
  try {
    const double first = problem.value(u);
    Iterate<P> current{std::move(u), first, problem.trial_gradient()};
    problem.accept();
    Iteration iteration{0, first, stationarity(problem, current.u, current.g), 0};
    const double tolerance = options.tolerance * iteration.gradient_norm;
    for (;;) {
      if (const auto end = reported(iteration, tolerance, options, report))
        return *end;
      Search<P> search;
      do
        search = weak_wolfe_search(problem, current, method.direction(problem, current));
      while (!search.found && method.restart());
      if (!search.found)
        return search.solver_failed ? Stop::solver_failed : Stop::no_decrease;
      problem.accept();
      Iterate<P>& next = *search.found;
      iteration = {iteration.number + 1, next.objective, stationarity(problem, next.u, next.g),
                   search.length};
      method.learn(problem, current, next, search.length);
      current = std::move(next);
    }
  } catch (const Interrupted&) {
    return Stop::interrupted;
  }
}

} // namespace signorini::optimize
