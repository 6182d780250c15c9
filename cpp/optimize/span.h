#pragma once
#include "optimize/problem.h"
#include <algorithm>
#include <numeric>
#include <span>
#include <utility>
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

/// A growing subspace with an orthonormal basis, so that frequent operations work on coordinates.
template <BoundedProblem P>
class Span {
public:
  using Vector = typename P::Vector;

  /// Coordinates of v, which the subspace contains from now on.
  Coordinates coordinates(const P& problem, Vector v) {
    const double length = norm(problem, v);
    Coordinates x(basis_.size());
    for (int pass = 0; pass < 2; ++pass) { // Gram-Schmidt, twice for rounding
      const Coordinates part = problem.pairings(problem.dual(v), basis_);
      v.add(scaled(part, -1), basis_);
      add(x, 1, part);
    }
    const double rest = norm(problem, v);
    constexpr double rounding = 1e-12;
    if (rest > rounding * length) {
      v.scale(1 / rest);
      basis_.push_back(share(std::move(v)));
      x.push_back(rest);
    }
    return x;
  }

  /// The vector with coordinates x; `like` is any vector of the problem.
  [[nodiscard]] Vector vector(const Coordinates& x, const Vector& like) const {
    Vector v = like;
    v.scale(0);
    v.add(x, std::span(basis_).first(x.size()));
    return v;
  }

  template <class Archive>
  void serialize(Archive& archive, const std::string& name) {
    serialize_list(archive, name, basis_,
                   [&](Shared<Vector>& q, const std::string& number) { archive(number, q); });
  }

  [[nodiscard]] std::size_t dimension() const { return basis_.size(); }

private:
  std::vector<Shared<Vector>> basis_;
};

} // namespace signorini::optimize
