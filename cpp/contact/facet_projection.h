// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/tangents.h"
#include "fem/surface.h"
#include <array>
#include <vector>

/// Facets of surfaces projected along a direction, and their intersections.
namespace signorini::contact {

using Point = std::array<double, 3>;
using Plane = std::array<double, 2>; ///< coordinates across ν; in the plane the second one is 0

/// Facet that is projected along ν.
struct Projected {
  std::array<Plane, 3> corners; ///< dim corners
  std::array<double, 3> level;  ///< their coordinates along ν, m
};

/// Coordinates across and along a direction ν.
class Projection {
public:
  /// `nu`: unit vector; `dim`: dimension of the bodies.
  Projection(const Point& nu, int dim)
      : dim_(static_cast<std::size_t>(dim)), nu_(nu), across_(tangents(nu, dim)) {}

  [[nodiscard]] Projected operator()(const fem::SurfaceMesh& surface,
                                     const fem::SurfaceMesh::Facet& facet) const;

private:
  std::size_t dim_;
  Point nu_;
  std::array<Point, 2> across_;
};

/// Length or area of a projected simplex; negative if its corners are clockwise.
[[nodiscard]] double measure(const std::array<Plane, 3>& corners, int dim);

/// Barycentric coordinates of x in a projected facet.
[[nodiscard]] std::array<double, 3> barycentric(const std::array<Plane, 3>& corners, const Plane& x, int dim);

/// Intersection of two projected facets, as simplices of positive measure.
[[nodiscard]] std::vector<std::array<Plane, 3>> intersection(std::array<Plane, 3> a, std::array<Plane, 3> b,
                                                             int dim);

} // namespace signorini::contact
