#pragma once
#include "optimize/archive.h"
#include "optimize/coordinates.h"
#include "optimize/unknowns.h"
#include <span>

namespace signorini::optimize {

/// A growing subspace with an orthonormal basis, so that frequent operations work on coordinates.
template <Unknowns U>
class Span {
public:
  using Vector = typename U::Vector;

  /// A vector belongs to the subspace if what is out of it is at most `dependent` times as long.
  explicit Span(double dependent) : dependent_(dependent) {}

  /// Coordinates of v, which the subspace contains from now on.
  Coordinates coordinates(const U& unknowns, Vector v) {
    const double length = norm(unknowns, v);
    Coordinates x(basis_.size());
    for (int pass = 0; pass < 2; ++pass) { // Gram-Schmidt, twice for rounding
      const Coordinates part = unknowns.pairings(unknowns.dual(v), basis_);
      v.add(scaled(part, -1), basis_);
      add(x, 1, part);
    }
    const double rest = norm(unknowns, v);
    if (rest > dependent_ * length) {
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
  double dependent_;
};

} // namespace signorini::optimize
