#pragma once
#include "optimize/descent.h"
#include <ranges>

namespace signorini::optimize {

/// L-BFGS directions by the two-loop recursion (Nocedal 1980), in the product of the problem and on the
/// values that bounds do not block (Bertsekas 1982): pairs are stored without blocked values, so that once
/// the blocked set no longer changes the method is that of the reduced problem. The operator applied is a
/// principal part of a positive definite one, so that J descends along its directions whatever the pairs are.
template <Unknowns U>
class LimitedMemory {
public:
  using Vector = typename U::Vector;

  explicit LimitedMemory(const Options& options) : options_(options.lbfgs) {}

  Vector direction(const U& unknowns, const Iterate<U>& at) const {
    const Vector down = negative(at.g);
    Vector d = tangential(unknowns, at.u, down);
    if (pairs_.empty()) {
      d.scale(length_ / norm(unknowns, d));
      return d;
    }
    std::vector<double> weights;
    for (const Pair& pair : pairs_ | std::views::reverse) {
      weights.push_back(unknowns.inner(*pair.s, d) / pair.sy);
      d.add(-weights.back(), *pair.y);
    }
    d.scale(scale_);
    for (const Pair& pair : pairs_) {
      d.add(weights.back() - unknowns.inner(*pair.y, d) / pair.sy, *pair.s);
      weights.pop_back();
    }
    unknowns.zero_blocked(d, at.u, down);
    return tangential(unknowns, at.u, d);
  }

  void learn(const U& unknowns, const Iterate<U>& from, const Iterate<U>& to, double) {
    const Vector down = negative(to.g);
    Vector s = difference(to.u, from.u), y = difference(to.g, from.g);
    length_ = norm(unknowns, s);
    unknowns.zero_blocked(s, to.u, down);
    unknowns.zero_blocked(y, to.u, down);
    const double sy = unknowns.inner(s, y), yy = unknowns.inner(y, y);
    if (!(sy > options_.least_cosine * length_ * std::sqrt(yy)))
      return;
    // Between the largest and the smallest inverse curvature seen (Dai, Al-Baali, Yang 2015): the curvatures
    // of J spread widely, from alpha up.
    scale_ = std::sqrt(unknowns.inner(s, s) / yy);
    pairs_.push_back({share(std::move(s)), share(std::move(y)), sy});
    if (pairs_.size() > options_.pairs)
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
  LbfgsOptions options_;
  std::vector<Pair> pairs_;
  double scale_ = 1;
  double length_ = 1; ///< of the last step, at first Cauchy's, the unit of length
};

template <TwiceDifferentiable P>
using Lbfgs = Descent<P, LimitedMemory<P>>;

} // namespace signorini::optimize
