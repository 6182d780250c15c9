// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/unknowns.h"
#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

namespace signorini::optimize {

/// Coordinates in an orthonormal basis; entries beyond the last are zero.
using Coordinates = std::vector<double>;

/// Returns the inner product a·b.
inline double dot(const Coordinates& a, const Coordinates& b) {
  const auto both = static_cast<std::ptrdiff_t>(std::min(a.size(), b.size()));
  return std::inner_product(a.begin(), a.begin() + both, b.begin(), 0.0);
}

inline double norm(const Coordinates& a) { return std::sqrt(dot(a, a)); }

/// Adds `factor` times b to a.
inline void add(Coordinates& a, double factor, const Coordinates& b) {
  a.resize(std::max(a.size(), b.size()));
  for (std::size_t i = 0; i < b.size(); ++i)
    a[i] += factor * b[i];
}

inline Coordinates scaled(Coordinates a, double factor) {
  for (double& x : a)
    x *= factor;
  return a;
}

/// Orthonormal basis of the span of given vectors.
class Orthonormal {
public:
  /// Creates an empty basis. A vector belongs to its span if the part outside is at most `dependent` times as
  /// long as the vector.
  explicit Orthonormal(double dependent) : dependent_(dependent) {}

  /// Extends the basis by all vectors in `more`, unless it would then have more than `most` dimensions.
  /// Returns whether it was extended.
  bool take(const std::vector<const Coordinates*>& more, std::size_t most) {
    const std::size_t before = vectors_.size();
    for (const Coordinates* given : more) {
      Coordinates x = *given;
      const double length = norm(x);
      for (int pass = 0; pass < 2; ++pass) // Gram-Schmidt, twice for rounding
        for (const Coordinates& q : vectors_)
          add(x, -dot(q, x), q);
      if (const double rest = norm(x); rest > dependent_ * length)
        vectors_.push_back(scaled(std::move(x), 1 / rest));
    }
    if (vectors_.size() <= most)
      return true;
    vectors_.resize(before);
    return false;
  }

  /// Returns the coordinates of x in this basis.
  [[nodiscard]] Coordinates of(const Coordinates& x) const {
    Coordinates all;
    for (const Coordinates& q : vectors_)
      all.push_back(dot(q, x));
    return all;
  }

  [[nodiscard]] const std::vector<Coordinates>& vectors() const { return vectors_; }

private:
  std::vector<Coordinates> vectors_;
  double dependent_;
};

/// Growing subspace of the problem's vectors with an orthonormal basis, so that frequent operations work on
/// coordinates. Stores the given vectors V and the Cholesky factor R of their Gram matrix, VᵀV = RᵀR. The
/// basis V R⁻¹ is never formed, so that adding a vector reads each stored vector only once.
template <Unknowns U>
class Span {
public:
  using Vector = typename U::Vector;
  using Compact = typename U::Compact;

  /// Creates an empty subspace. A vector belongs to the subspace if its part outside is at most `dependent`
  /// times as long as the vector.
  explicit Span(double dependent) : dependent_(dependent) {}

  /// Returns the coordinates of v; extends the subspace if v does not belong to it.
  Coordinates coordinates(const U& unknowns, Vector v) {
    if (std::exchange(rounded_, false))
      factorise(unknowns);
    Coordinates x(vectors_.size());
    for (double length = -1;;) {
      vectors_.emplace_back(v);
      v = Vector(vectors_.back()); // VᵀV is that of the stored vectors
      Coordinates part = unknowns.pairings(std::vector{unknowns.dual(v)}, vectors_);
      const double squared = part.back();
      part.pop_back();
      if (length < 0)
        length = std::sqrt(squared);
      to_basis(part);
      add(x, 1, part);
      if (!(squared > dependent_ * dependent_ * length * length)) { // only rounding is left
        vectors_.pop_back();
        return x;
      }
      Coordinates factors = to_vectors(part);
      if (const double rest = squared - dot(part, part); well_conditioned(factors, squared, rest)) {
        x.push_back(std::sqrt(rest));
        part.push_back(x.back());
        factor_.push_back(std::move(part));
        return x;
      }
      vectors_.pop_back();
      v.add(scaled(std::move(factors), -1), vectors_);
    }
  }

  /// Returns the vector with coordinates x; `like` is any vector of the problem.
  [[nodiscard]] Vector vector(const Coordinates& x, const Vector& like) const {
    Vector v = like;
    v.scale(0);
    v.add(to_vectors(x), std::span(vectors_).first(x.size()));
    return v;
  }

  /// Restricts the subspace to the span of an orthonormal basis; coordinates refer to this basis from now on.
  /// The basis vectors are stored in place of V. They must be orthonormal, since rounding turns the span of
  /// vectors that are far from orthogonal. Once rounded, they are orthonormal only to about seven digits, too
  /// few for new vectors with a small part outside. The next coordinates() therefore recomputes R from them.
  void restrict(const std::vector<Coordinates>& basis) {
    std::vector<Coordinates> factors;
    for (Coordinates x : basis) {
      x.resize(dimension());
      factors.push_back(to_vectors(std::move(x)));
    }
    Compact::combine(vectors_, factors);
    factor_.clear();
    while (dimension() < basis.size()) {
      factor_.emplace_back(dimension());
      factor_.back().push_back(1);
    }
    rounded_ = true;
  }

  template <class Archive>
  void serialize(Archive& archive, const std::string& name) {
    serialize_list(archive, name, vectors_,
                   [&](Compact& v, const std::string& number) { archive(number, v); });
    serialize_list(archive, name + "/factor", factor_,
                   [&](Coordinates& column, const std::string& number) { archive(number, column); });
    archive(name + "/rounded", rounded_);
  }

  /// Number of dimensions of the subspace.
  [[nodiscard]] std::size_t dimension() const { return factor_.size(); }

private:
  /// Recomputes R from the stored vectors, which are nearly orthonormal.
  void factorise(const U& unknowns) {
    constexpr std::size_t at_once = 8; // products are then bound by reading the vectors
    factor_.clear();
    for (std::size_t i = 0; i < vectors_.size();) {
      std::vector<Vector> duals;
      while (duals.size() < std::min(at_once, vectors_.size() - i))
        duals.push_back(unknowns.dual(Vector(vectors_[i + duals.size()])));
      const std::vector<double> products = unknowns.pairings(duals, vectors_);
      for (std::size_t d = 0; d < duals.size(); ++d, ++i) {
        const double* row = &products[d * vectors_.size()];
        Coordinates column(row, row + i);
        to_basis(column);
        column.push_back(std::sqrt(row[i] - dot(column, column)));
        factor_.push_back(std::move(column));
      }
    }
  }

  /// Converts products c with the stored vectors to coordinates, R⁻ᵀ c, in place.
  void to_basis(Coordinates& c) const {
    for (std::size_t j = 0; j < c.size(); ++j) {
      for (std::size_t i = 0; i < j; ++i)
        c[j] -= factor_[j][i] * c[i];
      c[j] /= factor_[j][j];
    }
  }

  /// Returns the coefficients R⁻¹ x of the stored vectors for the vector with coordinates x.
  [[nodiscard]] Coordinates to_vectors(Coordinates x) const {
    for (std::size_t j = x.size(); j-- > 0;) {
      x[j] /= factor_[j][j];
      for (std::size_t i = 0; i < j; ++i)
        x[i] -= factor_[j][i] * x[j];
    }
    return x;
  }

  /// Returns whether V stays well conditioned with a further vector of squared length `squared`. `factors`:
  /// coefficients of its part in the subspace; `rest`: squared length of its part outside. If false, only the
  /// part outside may be stored. The test bounds the new column of R⁻¹, scaled by the vectors' lengths.
  [[nodiscard]] bool well_conditioned(const Coordinates& factors, double squared, double rest) const {
    constexpr double most = 1e5; // rounding then leaves 11 digits of coordinates
    double sum = squared;
    for (std::size_t i = 0; i < factors.size(); ++i)
      sum += factors[i] * factors[i] * dot(factor_[i], factor_[i]);
    return sum <= most * most * rest;
  }

  std::vector<Compact> vectors_;
  std::vector<Coordinates> factor_; ///< columns of R, each one entry longer than the previous one
  bool rounded_ = false;            ///< whether vectors were rounded after R was computed
  double dependent_;
};

} // namespace signorini::optimize
