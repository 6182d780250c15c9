#pragma once
#include "optimize/descend.h"
#include <deque>
#include <ranges>
#include <vector>

namespace signorini::optimize {

/// Pairs of steps and changes of the gradient that L-BFGS keeps.
constexpr int lbfgs_pairs = 20;

/// Two-loop recursion (Nocedal 1980) in the product of the problem, on the free values (Bertsekas 1982):
/// pairs are stored without what was held, so that once the held values stay the same it is that of the
/// reduced problem. What is applied is the principal part of a positive operator, hence downhill whatever the
/// pairs hold.
template <BoundedProblem P>
class LimitedMemory {
public:
  using Vector = typename P::Vector;

  explicit LimitedMemory(double first_step) : length_(first_step) {}

  Vector direction(const P& problem, const Iterate<P>& at) const {
    Vector down = at.g;
    down.scale(-1);
    Vector d = tangential(problem, at.u, down);
    if (pairs_.empty()) {
      d.scale(length_ / norm(problem, d));
      return d;
    }
    std::vector<double> weights;
    for (const Pair& pair : pairs_ | std::views::reverse) {
      weights.push_back(problem.inner(pair.s, d) / pair.sy);
      d.add(-weights.back(), pair.y);
    }
    d.scale(scale_);
    for (const Pair& pair : pairs_) {
      d.add(weights.back() - problem.inner(pair.y, d) / pair.sy, pair.s);
      weights.pop_back();
    }
    problem.hold(d, at.u, down);
    return tangential(problem, at.u, d);
  }

  void learn(const P& problem, const Iterate<P>& from, const Iterate<P>& to, double) {
    Pair pair{to.u, to.g, 0};
    pair.s.add(-1, from.u);
    pair.y.add(-1, from.g);
    length_ = norm(problem, pair.s);
    Vector down = to.g;
    down.scale(-1);
    problem.hold(pair.s, to.u, down);
    problem.hold(pair.y, to.u, down);
    pair.sy = problem.inner(pair.s, pair.y);
    const double yy = problem.inner(pair.y, pair.y);
    constexpr double least_cosine = 1e-8;
    if (!(pair.sy > least_cosine * length_ * std::sqrt(yy)))
      return;
    // Between the largest and the smallest curvature seen (Dai, Al-Baali, Yang 2015): those of J spread
    // widely, from alpha up.
    scale_ = std::sqrt(problem.inner(pair.s, pair.s) / yy);
    pairs_.push_back(std::move(pair));
    if (pairs_.size() > lbfgs_pairs)
      pairs_.pop_front();
  }

  bool restart() {
    const bool had = !pairs_.empty();
    pairs_.clear();
    return had;
  }

private:
  struct Pair {
    Vector s, y;
    double sy;
  };
  std::deque<Pair> pairs_;
  double scale_ = 1;
  double length_; ///< of the last step
};

/// Limited-memory BFGS with bounds.
template <TwiceDifferentiable P, class Report>
[[nodiscard]] Ending<typename P::Vector> lbfgs(P& problem, typename P::Vector u, const Options& options, Report&& report) {
  return descend(problem, std::move(u), options, LimitedMemory<P>(options.first_step), report);
}

} // namespace signorini::optimize
