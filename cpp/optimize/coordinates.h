// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace signorini::optimize {

/// Coordinates in an orthonormal basis; those beyond the last are zero.
using Coordinates = std::vector<double>;

inline double dot(const Coordinates& a, const Coordinates& b) {
  const auto both = static_cast<std::ptrdiff_t>(std::min(a.size(), b.size()));
  return std::inner_product(a.begin(), a.begin() + both, b.begin(), 0.0);
}

inline double norm(const Coordinates& a) { return std::sqrt(dot(a, a)); }

/// a += factor b.
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

/// Orthonormal vectors that span what was taken, at most a given number of them.
class Orthonormal {
public:
  /// What is out of the span by at most this part of its length belongs to it.
  explicit Orthonormal(double dependent) : dependent_(dependent) {}

  /// Takes all of `more`, unless the span then has more than `most` dimensions. Returns whether it did.
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

  /// Coordinates by these vectors.
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

} // namespace signorini::optimize
