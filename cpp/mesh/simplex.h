// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/point.h"
#include <array>
#include <cmath>

namespace signorini::mesh {

/// Affine map x = corner + J ξ of a straight triangle in the plane z = 0, or of a tetrahedron.
class Simplex {
public:
  using Point = signorini::Point;

  /// `vertex(i)` points to the coordinates of vertex i.
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

  /// det J, whose sign depends on the order of the vertices.
  [[nodiscard]] double determinant() const { return determinant_; }

  /// Product of the lengths of the edges from vertex 0, m^dim.
  [[nodiscard]] double edge_product() const {
    double product = 1;
    for (int e = 0; e < dim_; ++e)
      product *= std::hypot(edges_[e][0], edges_[e][1], edges_[e][2]);
    return product;
  }

  /// |det J|, which is dim! times the volume, m^dim.
  [[nodiscard]] double volume() const { return std::abs(determinant_); }

  /// Gradient of the barycentric coordinate of vertex i, 1/m.
  [[nodiscard]] Point gradient(int i) const {
    Point g{};
    for (int e = 0; e < dim_; ++e)
      for (int k = 0; k < 3; ++k)
        g[k] += (i == 0 ? -1 : i == e + 1) * dual_[e][k] / determinant_;
    return g;
  }

  /// Reference coordinates ξ of a point x (3), inside or not.
  [[nodiscard]] Point reference(const double* x) const {
    const Point from{x[0] - corner_[0], x[1] - corner_[1], x[2] - corner_[2]};
    return {dot(dual_[0], from) / determinant_, dot(dual_[1], from) / determinant_,
            dot(dual_[2], from) / determinant_};
  }

  /// The point x at ξ (dim), m.
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
  std::array<Point, 3> edges_{}, dual_{}; ///< columns of J, rows of det(J) J⁻¹
  double determinant_ = 0;
};

} // namespace signorini::mesh
