// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/facet_projection.h"
#include "linalg/dense.h"
#include <algorithm>
#include <utility>

namespace signorini::contact {

namespace {

double orientation(const Plane& a, const Plane& b, const Plane& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

} // namespace

Projected Projection::operator()(const fem::SurfaceMesh& surface,
                                 const fem::SurfaceMesh::Facet& facet) const {
  Projected made{};
  for (std::size_t corner = 0; corner < dim_; ++corner) {
    const Point& x = surface.vertices[static_cast<std::size_t>(facet.vertices[corner])].x;
    made.corners[corner] = {dot(x, across_[0]), dot(x, across_[1])};
    made.level[corner] = dot(x, nu_);
  }
  return made;
}

double measure(const std::array<Plane, 3>& corners, int dim) {
  return dim == 2 ? corners[1][0] - corners[0][0] : orientation(corners[0], corners[1], corners[2]) / 2;
}

std::array<double, 3> barycentric(const std::array<Plane, 3>& corners, const Plane& x, int dim) {
  if (dim == 2) {
    const double s = (x[0] - corners[0][0]) / (corners[1][0] - corners[0][0]);
    return {1 - s, s, 0};
  }
  const double whole = orientation(corners[0], corners[1], corners[2]),
               second = orientation(corners[0], x, corners[2]) / whole,
               third = orientation(corners[0], corners[1], x) / whole;
  return {1 - second - third, second, third};
}

std::vector<std::array<Plane, 3>> intersection(std::array<Plane, 3> a, std::array<Plane, 3> b, int dim) {
  for (std::array<Plane, 3>* facet : {&a, &b})
    if (measure(*facet, dim) < 0)
      std::swap((*facet)[0], (*facet)[1]);
  if (dim == 2) {
    const double begin = std::max(a[0][0], b[0][0]), end = std::min(a[1][0], b[1][0]);
    if (end > begin)
      return {{Plane{begin, 0}, Plane{end, 0}, Plane{}}};
    return {};
  }
  std::vector<Plane> polygon(a.begin(), a.end()), cut; // by Sutherland and Hodgman
  for (std::size_t edge = 0; edge < 3 && !polygon.empty(); ++edge) {
    const Plane &from = b[edge], &to = b[(edge + 1) % 3];
    cut.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Plane &here = polygon[i], &next = polygon[(i + 1) % polygon.size()];
      const double side = orientation(from, to, here), next_side = orientation(from, to, next);
      if (side >= 0)
        cut.push_back(here);
      if (side * next_side < 0) {
        const double s = side / (side - next_side);
        cut.push_back({here[0] + s * (next[0] - here[0]), here[1] + s * (next[1] - here[1])});
      }
    }
    std::swap(polygon, cut);
  }
  std::vector<std::array<Plane, 3>> parts;
  for (std::size_t i = 2; i < polygon.size(); ++i)
    if (const std::array<Plane, 3> part{polygon[0], polygon[i - 1], polygon[i]}; measure(part, dim) > 0)
      parts.push_back(part);
  return parts;
}

} // namespace signorini::contact
