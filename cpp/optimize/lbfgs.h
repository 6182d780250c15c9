// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "linalg/simplex_qp.h"
#include "optimize/descent.h"
#include <algorithm>
#include <numeric>
#include <optional>

namespace signorini::optimize {

/// L-BFGS directions by the two-loop recursion (Nocedal 1980), in the problem's product and on the values
/// that bounds do not block (Bertsekas 1982). Blocked values are set to zero in the pairs that are stored.
/// Once the set of blocked values no longer changes, the method is L-BFGS for the problem reduced to the
/// other values. The approximation of the inverse Hessian is positive definite for any pairs, and so is its
/// restriction to the values that are not blocked. Therefore all directions are descent directions.
///
/// The recursion works on coefficients of the stored vectors, with their Gram matrix (Chen, Wang, Zhou 2014).
/// A direction reads the stored vectors twice, a new pair reads them once; computing products one by one
/// would apply the mass matrix to each vector.
template <Unknowns U>
class LimitedMemory {
public:
  using Vector = typename U::Vector;
  using Compact = typename U::Compact;

  explicit LimitedMemory(const Options& options) : options_(options.lbfgs) {
    options_.pairs = std::max<std::size_t>(1, std::min(options_.pairs, options.vectors / 2));
  }

  Vector direction(const U& unknowns, const Iterate<U>& at) const {
    const Vector down = negative(at.g);
    Vector d = tangential(unknowns, at.u, down);
    if (vectors_.empty()) {
      d.scale(length_ / norm(unknowns, d));
      return d;
    }
    // The direction is Σ factors_i vectors_i plus a multiple of d, with which `products` are taken.
    const std::size_t n = vectors_.size();
    std::vector<double> factors(n), products = unknowns.pairings(std::vector{unknowns.dual(d)}, vectors_);
    const auto product = [&](std::size_t i) {
      return std::inner_product(factors.begin(), factors.end(), &gram_[i * n], products[i]);
    };
    for (std::size_t s = n; s > 0;) {
      s -= 2;
      factors[s + 1] = -product(s) / gram_[s * n + s + 1];
    }
    for (std::vector<double>* part : {&factors, &products})
      for (double& x : *part)
        x *= scale_;
    for (std::size_t s = 0; s < n; s += 2)
      factors[s] = -factors[s + 1] / scale_ - product(s + 1) / gram_[s * n + s + 1];
    d.scale(scale_);
    d.add(factors, vectors_);
    unknowns.zero_blocked(d, at.u, down);
    return tangential(unknowns, at.u, d);
  }

  /// Returns the shortest convex combination of the gradients of `at` and of earlier iterates within `radius`
  /// of it, on values that are not blocked (Lewis, Overton 2013, section 6.3). Gradients and positions of the
  /// earlier iterates are computed from the stored pairs, which are rounded to single precision. This costs
  /// one product for each stored vector. Returns nothing if no earlier iterate is within `radius`.
  [[nodiscard]] std::optional<PathCombination> path_combination(const U& unknowns, const Iterate<U>& at,
                                                                double radius) const {
    const std::size_t n = vectors_.size(), steps = std::min(static_cast<std::size_t>(unbroken_), n / 2);
    const auto y = [&](std::size_t back) { return n - 2 * back + 1; }; // y so many steps back, from 1
    PathCombination found{.weights = std::vector<double>(steps + 1), .length = 0};
    std::vector<std::size_t> near{0}; // steps back
    double squared = 0;               // distance from `at`, squared
    for (std::size_t i = 1; i <= steps; ++i) {
      squared += gram_[(y(i) - 1) * n + y(i) - 1];
      for (std::size_t j = 1; j < i; ++j)
        squared += 2 * gram_[(y(i) - 1) * n + y(j) - 1];
      if (squared <= radius * radius)
        near.push_back(i);
    }
    if (near.size() == 1)
      return std::nullopt;
    // Gram matrix of the gradients r − Σ y of the iterates near by.
    const Vector r = negative(tangential(unknowns, at.u, negative(at.g)));
    const std::vector<double> products = unknowns.pairings(std::vector{unknowns.dual(r)}, vectors_);
    const double rr = unknowns.inner(r, r);
    std::vector<double> G;
    for (const std::size_t a : near)
      for (const std::size_t b : near) {
        double product = rr;
        for (std::size_t i = 1; i <= a; ++i)
          product -= products[y(i)];
        for (std::size_t j = 1; j <= b; ++j) {
          product -= products[y(j)];
          for (std::size_t i = 1; i <= a; ++i)
            product += gram_[y(i) * n + y(j)];
        }
        G.push_back(product);
      }
    const auto weights = simplex_qp(G, std::vector<double>(near.size()));
    if (!weights)
      return std::nullopt;
    for (std::size_t a = 0; a < near.size(); ++a) {
      found.weights[near[a]] = (*weights)[a];
      for (std::size_t b = 0; b < near.size(); ++b)
        found.length += (*weights)[a] * (*weights)[b] * G[a * near.size() + b];
    }
    found.length = std::sqrt(std::max(found.length, 0.0));
    return found;
  }

  /// Returns the iterate that is `steps` steps before `at`.
  [[nodiscard]] Vector before(const Iterate<U>& at, std::size_t steps) const {
    Vector u = at.u;
    std::vector<double> factors(vectors_.size());
    for (std::size_t i = 1; i <= steps; ++i)
      factors[vectors_.size() - 2 * i] = -1;
    u.add(factors, vectors_);
    return u;
  }

  /// Stores the pair of step and gradient difference of a step.
  void learn(const U& unknowns, const Iterate<U>& from, const Iterate<U>& to, double) {
    const Vector down = negative(to.g);
    Vector s = difference(to.u, from.u), y = difference(to.g, from.g);
    length_ = norm(unknowns, s);
    unknowns.zero_blocked(s, to.u, down);
    unknowns.zero_blocked(y, to.u, down);
    take(unknowns, s, y, length_);
  }

  /// Takes over the pairs of a search on another problem. `interpolate`: transfers vectors of that problem to
  /// this one. Pairs whose curvature is no longer positive are dropped.
  template <class Interpolate>
  void inherit(const LimitedMemory& other, const U& unknowns, const Interpolate& interpolate) {
    length_ = other.length_;
    const std::size_t pairs = other.vectors_.size() / 2;
    for (std::size_t i = pairs - std::min(pairs, options_.pairs); i < pairs; ++i) {
      const Vector s = interpolate(Vector(other.vectors_[2 * i])),
                   y = interpolate(Vector(other.vectors_[2 * i + 1]));
      take(unknowns, s, y, norm(unknowns, s));
    }
    unbroken_ = 0; // no pair is of this problem
  }

  /// Drops all pairs; returns whether there were any.
  bool restart() {
    const bool had = !vectors_.empty();
    unbroken_ = 0;
    vectors_.clear();
    gram_.clear();
    return had;
  }

  /// Drops the oldest pairs until at most `vectors` vectors are stored.
  void store_at_most(std::size_t vectors) {
    while (vectors_.size() > vectors)
      forget_oldest();
  }

  template <class Archive>
  void serialize(Archive& archive) {
    archive("lbfgs/scale", scale_);
    archive("lbfgs/length", length_);
    archive("lbfgs/unbroken", unbroken_);
    serialize_list(archive, "lbfgs/vectors", vectors_,
                   [&](Compact& v, const std::string& name) { archive(name, v); });
    archive("lbfgs/gram", gram_);
  }

private:
  /// Stores the pair (s, y), unless rounding decides the sign of its curvature. `length`: length of the step
  /// with blocked values included.
  void take(const U& unknowns, const Vector& s, const Vector& y, double length) {
    const std::size_t n = vectors_.size();
    const std::vector<Vector> duals{unknowns.dual(s), unknowns.dual(y)};
    std::vector<Compact> all = vectors_;
    all.emplace_back(s);
    all.emplace_back(y);
    const std::vector<double> products = unknowns.pairings(duals, all); // 2 × (n + 2)
    const double ss = products[n], sy = products[n + 1], yy = products[2 * n + 3];
    // Pairs without blocked values do not lead back to earlier iterates.
    const bool whole = ss >= (1 - options_.least_cosine) * length * length;
    unbroken_ = whole ? unbroken_ + 1 : 0;
    if (!(sy > options_.least_cosine * length * std::sqrt(yy))) {
      unbroken_ = 0;
      return;
    }
    // Between the largest and the smallest inverse curvature seen (Dai, Al-Baali, Yang 2015): the curvatures
    // of J spread widely, from alpha up.
    scale_ = std::sqrt(ss / yy);
    std::vector<double> gram;
    for (std::size_t i = 0; i < n; ++i) {
      gram.insert(gram.end(), &gram_[i * n], &gram_[i * n] + n);
      gram.insert(gram.end(), {products[i], products[n + 2 + i]});
    }
    gram.insert(gram.end(), products.begin(), products.end());
    gram_ = std::move(gram);
    vectors_ = std::move(all);
    store_at_most(2 * options_.pairs);
  }

  void forget_oldest() {
    const std::size_t n = vectors_.size();
    std::vector<double> gram;
    for (std::size_t i = 2; i < n; ++i)
      gram.insert(gram.end(), &gram_[i * n + 2], &gram_[i * n] + n);
    gram_ = std::move(gram);
    vectors_.erase(vectors_.begin(), vectors_.begin() + 2);
  }

  LbfgsOptions options_;
  std::vector<Compact> vectors_; ///< s and y of each pair, the oldest first
  std::vector<double> gram_;     ///< Gram matrix (vectors × vectors)
  int unbroken_ = 0;             ///< number of latest pairs that join consecutive iterates
  double scale_ = 1;
  double length_ = 1; ///< length of the last step; initially Cauchy's step, 1
};

template <TwiceDifferentiable P>
using Lbfgs = Descent<P, LimitedMemory<P>>;

} // namespace signorini::optimize
