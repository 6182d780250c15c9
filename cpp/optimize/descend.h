#pragma once
#include "optimize/kink.h"

namespace signorini::optimize {

/// Descent along the directions of `method`, which must be downhill. Where there is no way down one of them
/// it is asked to start afresh with the steepest. Where that leads nowhere either, or steps have become
/// short, as they do among kinks, a model of the pieces that meet there takes over, and ends the search with
/// a certificate.
///
/// Of `method`: direction(problem, at) is tangential and as long as the first trial step is to be;
/// learn(problem, from, to, t) tells what t of it led to; restart() is false if the last direction was the
/// steepest. `report(iteration)` is told of the first guess and of each accepted iterate, which is then the
/// problem's current point. Interrupted from the problem ends the search with the last accepted iterate.
/// Throws SolverFailure if the objective or its gradient is not finite.
template <TwiceDifferentiable P, class Method, class Report>
[[nodiscard]] Ending<typename P::Vector> descend(P& problem, typename P::Vector u, const Options& options,
                                                 Method method, Report&& report) {
  constexpr double short_step = 1e-3; // of the length of a control that matters
  constexpr int enough_short_steps = 3;
  problem.project(u);
  try {
    const double first = problem.value(u);
    Iterate<P> current{std::move(u), first, problem.trial_gradient()};
    problem.accept();
    Iteration iteration{0, first, stationarity(problem, current.u, current.g), 0};
    const double tolerance = options.tolerance * iteration.gradient_norm;
    std::optional<KinkModel<P>> kink; // takes over from `method`
    bool fresh = false;               // it has not moved yet
    const auto take_over = [&] {
      kink.emplace(problem, current, options.first_step);
      fresh = true;
    };
    for (int short_steps = 0;;) {
      if (const auto end = reported(iteration, tolerance, options, report))
        return {*end};
      std::optional<Iterate<P>> next;
      double t = 1;
      while (!next) {
        if (kink) {
          typename KinkModel<P>::Step step = kink->step(problem, current, tolerance);
          if (step.end == KinkModel<P>::End::stationary)
            return {Stop::kink, kink->certificate(current)};
          if (step.end == KinkModel<P>::End::nowhere) {
            if (fresh)
              return {Stop::no_decrease};
            take_over();
          }
          fresh = fresh && !step.found;
          if (step.at_other_bounds)
            kink.reset();
          next = std::move(step.found);
          continue;
        }
        Search<P> search;
        do
          search = weak_wolfe_search(problem, current, method.direction(problem, current));
        while (!search.found && method.restart());
        if (search.found)
          method.learn(problem, current, *search.found, search.length);
        else if (search.solver_failed)
          return {Stop::solver_failed};
        else
          take_over();
        t = search.length;
        next = std::move(search.found);
      }
      problem.accept();
      typename P::Vector moved = next->u;
      moved.add(-1, current.u);
      short_steps = norm(problem, moved) < short_step * options.first_step ? short_steps + 1 : 0;
      current = std::move(*next);
      iteration = {iteration.number + 1, current.objective, stationarity(problem, current.u, current.g), t};
      if (kink ? kink->full() : short_steps >= enough_short_steps)
        take_over();
    }
  } catch (const Interrupted&) {
    return {Stop::interrupted};
  }
}

} // namespace signorini::optimize
