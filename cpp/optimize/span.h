#pragma once
#include "optimize/archive.h"
#include "optimize/coordinates.h"
#include "optimize/unknowns.h"
#include <span>

namespace signorini::optimize {

/// A growing subspace with an orthonormal basis, so that frequent operations work on coordinates. What is
/// stored are vectors V as they came, and the Cholesky factor of their Gram matrix, VᵀV = RᵀR: the basis is
/// V R⁻¹, which is never formed, so that a new vector reads those stored once.
template <Unknowns U>
class Span {
public:
  using Vector = typename U::Vector;

  /// A vector belongs to the subspace if what is out of it is at most `dependent` times as long.
  explicit Span(double dependent) : dependent_(dependent) {}

  /// Coordinates of v, which the subspace contains from now on.
  Coordinates coordinates(const U& unknowns, Vector v) {
    // Where less of v is new, what is in the subspace is taken out of v first: the difference of squares
    // would not be accurate, and with many such vectors VᵀV would be singular.
    constexpr double accurate = 0.5;
    Coordinates x(vectors_.size());
    const auto last = std::make_shared<Vector>(std::move(v));
    double length = -1;
    for (;;) {
      const std::vector<Vector> dual{unknowns.dual(*last)};
      vectors_.push_back(last);
      Coordinates part = unknowns.pairings(dual, vectors_);
      const double squared = part.back();
      part.pop_back();
      if (length < 0)
        length = std::sqrt(squared);
      to_basis(part);
      const double rest = squared - dot(part, part);
      if (!(squared > dependent_ * dependent_ * length * length)) { // rounding is left
        vectors_.pop_back();
        add(x, 1, part);
        return x;
      }
      if (rest > accurate * squared) {
        add(x, 1, part);
        x.push_back(std::sqrt(rest));
        part.push_back(x.back());
        factor_.push_back(std::move(part));
        return x;
      }
      vectors_.pop_back();
      add(x, 1, part);
      last->add(scaled(to_vectors(std::move(part)), -1), vectors_);
    }
  }

  /// The vector with coordinates x; `like` is any vector of the problem.
  [[nodiscard]] Vector vector(const Coordinates& x, const Vector& like) const {
    Vector v = like;
    v.scale(0);
    v.add(to_vectors(x), std::span(vectors_).first(x.size()));
    return v;
  }

  template <class Archive>
  void serialize(Archive& archive, const std::string& name) {
    serialize_list(archive, name, vectors_,
                   [&](Shared<Vector>& v, const std::string& number) { archive(number, v); });
    serialize_list(archive, name + "/factor", factor_,
                   [&](Coordinates& column, const std::string& number) { archive(number, column); });
  }

  [[nodiscard]] std::size_t dimension() const { return factor_.size(); }

private:
  /// c = R⁻ᵀ c, of products with the vectors: coordinates.
  void to_basis(Coordinates& c) const {
    for (std::size_t j = 0; j < c.size(); ++j) {
      for (std::size_t i = 0; i < j; ++i)
        c[j] -= factor_[j][i] * c[i];
      c[j] /= factor_[j][j];
    }
  }

  /// R⁻¹ x, of coordinates: factors of the vectors.
  [[nodiscard]] Coordinates to_vectors(Coordinates x) const {
    for (std::size_t j = x.size(); j-- > 0;) {
      x[j] /= factor_[j][j];
      for (std::size_t i = 0; i < j; ++i)
        x[i] -= factor_[j][i] * x[j];
    }
    return x;
  }

  std::vector<Shared<Vector>> vectors_;
  std::vector<Coordinates> factor_; ///< columns of R, of one entry more each
  double dependent_;
};

} // namespace signorini::optimize
