// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/descent.h"
#include <algorithm>
#include <utility>

namespace signorini::optimize {

/// Newton directions by conjugate gradients on the values that bounds do not block. The iterations end at the
/// trust region, at negative curvature (Steihaug 1983, Toint 1981), or when the residual suffices for
/// superlinear convergence; more accuracy is wasted where active sets change. A step that is too long is
/// shortened and not recomputed (Nocedal, Yuan 1998), since a trial costs one sweep, a Hessian product two.
/// At a kink the quadratic model is one-sided, so that the search may end above the minimiser.
template <TwiceDifferentiable P>
class TruncatedNewton {
public:
  using Vector = typename P::Vector;

  explicit TruncatedNewton(const Options& options) : options_(options.newton) {}

  Vector direction(P& problem, const Iterate<P>& at) {
    const Vector down = negative(at.g);
    Vector r = tangential(problem, at.u, down);
    double rr = problem.inner(r, r);
    const double first = std::sqrt(rr);
    largest_norm_ = std::max(largest_norm_, first);
    if (steepest_) {
      r.scale(radius_ / first);
      return r;
    }
    const double enough =
        std::min(options_.residual, std::pow(first / largest_norm_, options_.order)) * first;
    Vector d = r, p = r;
    d.scale(0);
    double dd = 0, dp = 0, pp = rr;
    predicted_ = 0;
    on_boundary_ = false;
    for (int products = 0; products < options_.products && std::sqrt(rr) > enough; ++products) {
      Vector Hp = problem.hessian_product(p);
      problem.zero_blocked(Hp, at.u, down);
      const double curvature = problem.inner(p, Hp), step = rr / curvature;
      if (!(curvature > 0) || dd + 2 * step * dp + step * step * pp >= radius_ * radius_) {
        const double rest = radius_ * radius_ - dd;
        const double to_boundary = rest / (dp + std::sqrt(dp * dp + pp * rest));
        d.add(to_boundary, p);
        predicted_ += to_boundary * rr - to_boundary * to_boundary / 2 * curvature;
        on_boundary_ = true;
        break;
      }
      d.add(step, p);
      r.add(-step, Hp);
      predicted_ += step * rr / 2;
      dd += 2 * step * dp + step * step * pp;
      const double before = std::exchange(rr, problem.inner(r, r));
      const double beta = rr / before;
      dp = beta * (dp + step * pp);
      pp = rr + beta * beta * pp;
      p.scale(beta);
      p.add(1, r);
    }
    return tangential(problem, at.u, d);
  }

  void learn(const P& problem, const Iterate<P>& from, const Iterate<P>& to, double t) {
    const double length = norm(problem, difference(to.u, from.u)),
                 ratio = (from.objective - to.objective) / predicted_;
    if (std::exchange(steepest_, false) || t < 1)
      radius_ = length;
    else if (ratio < options_.poor)
      radius_ = length / options_.radius_factor;
    else if (t > 1 || (on_boundary_ && ratio > options_.good))
      radius_ = std::max(radius_, options_.radius_factor * length);
  }

  /// Does nothing: no vectors are stored.
  void store_at_most(std::size_t) {}

  /// Takes over the trust region of a search on another problem.
  void inherit(const TruncatedNewton& other, const P&, const auto&) {
    radius_ = other.radius_;
    largest_norm_ = other.largest_norm_;
  }

  /// Makes the next direction steepest descent. Returns false if the last direction was steepest descent.
  bool restart() { return !std::exchange(steepest_, true); }

  template <class Archive>
  void serialize(Archive& archive) {
    archive("newton-cg/radius", radius_);
    archive("newton-cg/first", largest_norm_);
    archive("newton-cg/steepest", steepest_);
  }

private:
  NewtonOptions options_;
  double radius_ = options_.radius; ///< radius of the trust region
  double largest_norm_ = 0;         ///< largest gradient norm so far, without the values that bounds block
  double predicted_ = 0;            ///< decrease of the quadratic model along the last direction
  bool on_boundary_ = false, steepest_ = false;
};

template <TwiceDifferentiable P>
using NewtonCg = Descent<P, TruncatedNewton<P>>;

} // namespace signorini::optimize
