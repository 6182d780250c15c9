#pragma once
#include "optimize/descent.h"
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
      weights.push_back(problem.inner(*pair.s, d) / pair.sy);
      d.add(-weights.back(), *pair.y);
    }
    d.scale(scale_);
    for (const Pair& pair : pairs_) {
      d.add(weights.back() - problem.inner(*pair.y, d) / pair.sy, *pair.s);
      weights.pop_back();
    }
    problem.hold(d, at.u, down);
    return tangential(problem, at.u, d);
  }

  void learn(const P& problem, const Iterate<P>& from, const Iterate<P>& to, double) {
    Vector s = to.u, y = to.g, down = to.g;
    s.add(-1, from.u);
    y.add(-1, from.g);
    length_ = norm(problem, s);
    down.scale(-1);
    problem.hold(s, to.u, down);
    problem.hold(y, to.u, down);
    const double sy = problem.inner(s, y), yy = problem.inner(y, y);
    constexpr double least_cosine = 1e-8;
    if (!(sy > least_cosine * length_ * std::sqrt(yy)))
      return;
    // Between the largest and the smallest curvature seen (Dai, Al-Baali, Yang 2015): those of J spread
    // widely, from alpha up.
    scale_ = std::sqrt(problem.inner(s, s) / yy);
    pairs_.push_back({share(std::move(s)), share(std::move(y)), sy});
    if (pairs_.size() > lbfgs_pairs)
      pairs_.erase(pairs_.begin());
  }

  bool restart() {
    const bool had = !pairs_.empty();
    pairs_.clear();
    return had;
  }

  template <class Archive>
  void exchange(Archive& archive) {
    archive("lbfgs/scale", scale_);
    archive("lbfgs/length", length_);
    exchange_list(archive, "lbfgs/pairs", pairs_, [&](Pair& pair, const std::string& name) {
      archive(name + "/s", pair.s);
      archive(name + "/y", pair.y);
      archive(name + "/sy", pair.sy);
    });
  }

private:
  struct Pair {
    Shared<Vector> s, y;
    double sy = 0;
  };
  std::vector<Pair> pairs_;
  double scale_ = 1;
  double length_ = 1; ///< of the last step; at first of that which units were measured by
};

/// Limited-memory BFGS with bounds.
template <TwiceDifferentiable P, class Report, class Keeper = NoKeeper>
[[nodiscard]] Ending<typename P::Vector> lbfgs(P& problem, typename P::Vector u, const Options& options,
                                               Report&& report, Keeper&& keeper = {}) {
  return search(problem, std::move(u), options,
                Descent<Dimensionless<P>, LimitedMemory<Dimensionless<P>>>({}), report, keeper);
}

} // namespace signorini::optimize
