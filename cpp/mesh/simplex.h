// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/point.h"
#include <array>
#include <cmath>

namespace signorini::mesh {

/// Affine map x = corner + J ξ from the reference simplex to a straight triangle in the plane z = 0 or a
/// tetrahedron.
class Simplex {
public:
  using Point = signorini::Point;

  /// `vertex(i)` returns the address of the three coordinates of vertex i, m.
  template <class Vertex>
  Simplex(int dim, Vertex&& vertex) : dim_(dim) {
    for (int k = 0; k < 3; ++k)
      corner_[k] = vertex(0)[k];
    for (int e = 0; e < dim; ++e)
      for (int k = 0; k < 3; ++k)
        edges_[e][k] = vertex(e + 1)[k] - corner_[k];
    const Point& a = edges_[0];
    const Point& b = edges_[1];
    if (dim == 2)
      edges_[2] = {0, 0, 1};
    const Point& c = edges_[2];
    dual_ = {cross(b, c), cross(c, a), cross(a, b)};
    determinant_ = dot(a, dual_[0]);
  }

  /// det J, m^dim; its sign depends on the order of the vertices.
  [[nodiscard]] double determinant() const { return determinant_; }

  /// Product of the lengths of the edges at vertex 0, m^dim: the scale of abs_determinant().
  [[nodiscard]] double edge_product() const {
    double product = 1;
    for (int e = 0; e < dim_; ++e)
      product *= std::hypot(edges_[e][0], edges_[e][1], edges_[e][2]);
    return product;
  }

  /// |det J|, m^dim: dim! times the area or volume of the simplex.
  [[nodiscard]] double abs_determinant() const { return std::abs(determinant_); }

  /// Gradient of the barycentric coordinate of vertex i, 1/m.
  [[nodiscard]] Point gradient(int i) const {
    Point g{};
    for (int e = 0; e < dim_; ++e)
      for (int k = 0; k < 3; ++k)
        g[k] += (i == 0 ? -1 : i == e + 1) * dual_[e][k] / determinant_;
    return g;
  }

  /// Reference coordinates ξ of a point x (3), which may be outside the simplex.
  [[nodiscard]] Point reference(const double* x) const {
    const Point from{x[0] - corner_[0], x[1] - corner_[1], x[2] - corner_[2]};
    return {dot(dual_[0], from) / determinant_, dot(dual_[1], from) / determinant_,
            dot(dual_[2], from) / determinant_};
  }

  /// Point x (m) with the reference coordinates ξ (dim).
  [[nodiscard]] Point point(const double* xi) const {
    Point x = corner_;
    for (int e = 0; e < dim_; ++e)
      for (int k = 0; k < 3; ++k)
        x[k] += xi[e] * edges_[e][k];
    return x;
  }

private:
  int dim_;
  Point corner_{};
  std::array<Point, 3> edges_{}, dual_{}; ///< columns of J; rows of det(J) J⁻¹
  double determinant_ = 0;
};

} // namespace signorini::mesh
