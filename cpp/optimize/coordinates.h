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

} // namespace signorini::optimize
