#pragma once
#include "optimize/kink.h"

namespace signorini::optimize {

/// Descent along the directions of `Method`, which must be downhill. Where there is no way down one of them
/// it is asked to start afresh with the steepest. Where that leads nowhere either, or steps have become
/// short, as they do among kinks, a model of the pieces that meet there takes over, and ends the search with
/// a certificate.
///
/// Of `Method`: direction(problem, at) is tangential and as long as the first trial step is to be;
/// learn(problem, from, to, t) tells what t of it led to; restart() is false if the last direction was the
/// steepest; exchange(archive).
template <TwiceDifferentiable P, class Method>
class Descent {
public:
  using Vector = typename P::Vector;

  explicit Descent(Method method) : method_(std::move(method)) {}

  std::optional<Ending<Vector>> advance(P& problem, State<P, Descent>& state, const Options& options) {
    Iterate<P>& current = state.current;
    const double tolerance = options.tolerance * state.first_norm;
    std::optional<Iterate<P>> next;
    double t = 1;
    while (!next) {
      if (kink_) {
        Step step = kink_->step(problem, current, tolerance);
        if (step.certificate)
          return Ending<Vector>{Stop::kink, std::move(step.certificate)};
        if (!step.found) {
          if (fresh_)
            return Ending<Vector>{Stop::no_decrease};
          take_over(problem, current);
        }
        fresh_ = fresh_ && !step.found;
        if (step.at_other_bounds)
          kink_.reset();
        next = std::move(step.found);
        continue;
      }
      Search<P> search;
      do
        search = weak_wolfe_search(problem, current, method_.direction(problem, current));
      while (!search.found && method_.restart());
      if (search.found)
        method_.learn(problem, current, *search.found, search.length);
      else if (search.solver_failed)
        return Ending<Vector>{Stop::solver_failed};
      else
        take_over(problem, current);
      t = search.length;
      next = std::move(search.found);
    }
    problem.accept();
    Vector moved = next->u;
    moved.add(-1, current.u);
    const double length = norm(problem, moved);
    longest_ = std::max(longest_, length);
    constexpr double short_step = 1e-3; // of the longest
    constexpr int enough_short_steps = 3;
    short_steps_ = length < short_step * longest_ ? short_steps_ + 1 : 0;
    current = std::move(*next);
    state.iteration = {state.iteration.number + 1, current.objective,
                       stationarity(problem, current.u, current.g), t};
    if (kink_ ? kink_->full() : short_steps_ >= enough_short_steps)
      take_over(problem, current);
    return std::nullopt;
  }

  template <class Archive>
  void exchange(Archive& archive) {
    method_.exchange(archive);
    archive("longest_step", longest_);
    archive("short_steps", short_steps_);
    archive("kink/fresh", fresh_);
    bool takes_over = kink_.has_value();
    archive("kink/takes_over", takes_over);
    if (takes_over && !kink_)
      kink_.emplace(longest_);
    if (kink_)
      kink_->exchange(archive);
  }

private:
  using Step = typename KinkModel<P>::Step;

  void take_over(const P& problem, const Iterate<P>& at) {
    kink_.emplace(problem, at, longest_);
    fresh_ = true;
  }

  Method method_;
  double longest_ = 1;               ///< step so far, or that which units were measured by
  int short_steps_ = 0;              ///< the last so many
  std::optional<KinkModel<P>> kink_; ///< takes over from the method
  bool fresh_ = false;               ///< it has not moved yet
};

} // namespace signorini::optimize
