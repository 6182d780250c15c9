#pragma once
#include "optimize/descent.h"
#include <ranges>
#include <vector>

namespace signorini::optimize {

/// Pairs of steps and gradient differences that L-BFGS keeps.
constexpr int lbfgs_pairs = 20;

/// L-BFGS directions by the two-loop recursion (Nocedal 1980), in the product of the problem and on the
/// values that bounds do not block (Bertsekas 1982): pairs are stored without blocked values, so that once
/// the blocked set no longer changes the method is that of the reduced problem. The operator applied is a
/// principal part of a positive definite one, so that J descends along its directions whatever the pairs are.
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
    problem.zero_blocked(d, at.u, down);
    return tangential(problem, at.u, d);
  }

  void learn(const P& problem, const Iterate<P>& from, const Iterate<P>& to, double) {
    Vector s = to.u, y = to.g, down = to.g;
    s.add(-1, from.u);
    y.add(-1, from.g);
    length_ = norm(problem, s);
    down.scale(-1);
    problem.zero_blocked(s, to.u, down);
    problem.zero_blocked(y, to.u, down);
    const double sy = problem.inner(s, y), yy = problem.inner(y, y);
    constexpr double least_cosine = 1e-8;
    if (!(sy > least_cosine * length_ * std::sqrt(yy)))
      return;
    // Between the largest and the smallest inverse curvature seen (Dai, Al-Baali, Yang 2015): the curvatures
    // of J spread widely, from alpha up.
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
  void serialize(Archive& archive) {
    archive("lbfgs/scale", scale_);
    archive("lbfgs/length", length_);
    serialize_list(archive, "lbfgs/pairs", pairs_, [&](Pair& pair, const std::string& name) {
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
  double length_ = 1; ///< of the last step, at first Cauchy's, the unit of length
};

/// Limited-memory BFGS with bounds.
template <TwiceDifferentiable P, class Report, class Checkpointer = NoCheckpointer>
[[nodiscard]] Result<typename P::Vector> lbfgs(P& problem, typename P::Vector u, const Options& options,
                                               Report&& report, Checkpointer&& keeper = {}) {
  return minimize(problem, std::move(u), options,
                  Descent<Dimensionless<P>, LimitedMemory<Dimensionless<P>>>({}), report, keeper);
}

} // namespace signorini::optimize
