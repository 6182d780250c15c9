// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/obstacle_surface.h"
#include "base/error.h"
#include "base/point.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <utility>

namespace signorini::contact {
namespace {

constexpr double much_larger = 2.5; ///< ratio of obstacle to box size above which the surface is cut

void add_point(ObstacleSurface& surface, std::size_t dim, const Point& x) {
  surface.points.insert(surface.points.end(), x.begin(), x.begin() + static_cast<std::ptrdiff_t>(dim));
}

/// Surface of a plane: a segment or a rectangle that spans the box.
ObstacleSurface flat(const Obstacle& obstacle, const Obstacle::Place& place, std::size_t dim,
                     const Box& box) {
  const Point normal = obstacle.at(place.point.data(), place).normal;
  Point right{normal[1], -normal[0], 0}, up{};
  if (dim == 3) {
    Point axis{};
    axis[static_cast<std::size_t>(std::ranges::min_element(normal, {}, [](double n) { return std::abs(n); }) -
                                  normal.begin())] = 1;
    right = cross(axis, normal);
    right = scaled(1 / length(right), right);
    up = cross(normal, right);
  }
  constexpr double infinite = std::numeric_limits<double>::infinity();
  std::array<double, 2> low{infinite, infinite}, high{-infinite, -infinite}; // along `right` and `up`
  for (unsigned corner = 0; corner < 1U << dim; ++corner) {
    Point x{};
    for (std::size_t c = 0; c < dim; ++c)
      x[c] = (corner >> c & 1U ? box.high[c] : box.low[c]) - place.point[c];
    for (std::size_t side = 0; side < 2; ++side) {
      const double reach = dot(x, side == 0 ? right : up);
      low[side] = std::min(low[side], reach);
      high[side] = std::max(high[side], reach);
    }
  }
  ObstacleSurface surface;
  const auto add = [&](double across, double above) {
    add_point(surface, dim, along(along(place.point, across, right), above, up));
  };
  if (dim == 2) { // with the outside to the left
    add(high[0], 0);
    add(low[0], 0);
    surface.facets = {1, 0};
  } else {
    add(low[0], low[1]);
    add(high[0], low[1]);
    add(high[0], high[1]);
    add(low[0], high[1]);
    surface.facets = {0, 1, 2, 0, 2, 3};
  }
  return surface;
}

/// Zero level set of an obstacle's level, interpolated linearly on the simplices into which the cubes of a
/// grid are divided.
class Contour {
public:
  Contour(const Obstacle& obstacle, const Obstacle::Place& place, std::size_t dim, const Box& box, int cells)
      : obstacle_(obstacle), place_(place), dim_(dim), box_(box) {
    width_ = box.longest_side() / cells;
    for (std::size_t c = 0; c < dim; ++c)
      count_[c] =
          static_cast<std::size_t>(std::max(2.0, std::round((box.high[c] - box.low[c]) / width_))) + 1;
    levels_.resize(count_[0] * count_[1] * count_[2]);
    for (std::size_t node = 0; node < levels_.size(); ++node)
      levels_[node] = level(position(node));
  }

  ObstacleSurface operator()() {
    // The simplices of a cube lead from its lowest corner to the highest one, along the axes in each order.
    std::array<std::size_t, 3> order{0, 1, 2};
    const auto end = order.begin() + static_cast<std::ptrdiff_t>(dim_);
    for (std::size_t node = 0; node < levels_.size(); ++node) {
      if (!begins_cube(node))
        continue;
      std::sort(order.begin(), end);
      do {
        std::array<std::size_t, 4> corners{node};
        for (std::size_t c = 0; c < dim_; ++c)
          corners[c + 1] = corners[c] + stride(order[c]);
        add_simplex(std::span(corners).first(dim_ + 1));
      } while (std::next_permutation(order.begin(), end));
    }
    return std::move(surface_);
  }

private:
  [[nodiscard]] std::size_t stride(std::size_t axis) const {
    return axis == 0 ? 1 : axis == 1 ? count_[0] : count_[0] * count_[1];
  }
  [[nodiscard]] std::size_t number(std::size_t node, std::size_t axis) const {
    return node / stride(axis) % count_[axis];
  }
  [[nodiscard]] bool begins_cube(std::size_t node) const {
    for (std::size_t c = 0; c < dim_; ++c)
      if (number(node, c) + 1 == count_[c])
        return false;
    return true;
  }
  [[nodiscard]] Point position(std::size_t node) const {
    Point x{};
    for (std::size_t c = 0; c < dim_; ++c) {
      const double part = static_cast<double>(number(node, c)) / static_cast<double>(count_[c] - 1);
      x[c] = std::lerp(box_.low[c], box_.high[c], part);
    }
    return x;
  }
  /// Level of the obstacle at x; NaN where it is undefined.
  [[nodiscard]] double level(const Point& x) const {
    try {
      return obstacle_.level(x.data(), place_);
    } catch (const UserError&) {
      return std::numeric_limits<double>::quiet_NaN();
    }
  }

  void add_simplex(std::span<const std::size_t> corners) {
    std::array<std::size_t, 4> inside{}, outside{};
    std::size_t in = 0, out = 0;
    for (const std::size_t node : corners) {
      if (!std::isfinite(levels_[node]))
        return;
      (levels_[node] < 0 ? inside[in++] : outside[out++]) = node;
    }
    if (in == 0 || out == 0)
      return;
    const Point outwards = from(position(inside[0]), position(outside[0]));
    if (dim_ == 3 && in == 2) {
      const std::array quad{crossing(inside[0], outside[0]), crossing(inside[0], outside[1]),
                            crossing(inside[1], outside[1]), crossing(inside[1], outside[0])};
      add_facet({quad[0], quad[1], quad[2]}, outwards);
      add_facet({quad[0], quad[2], quad[3]}, outwards);
      return;
    }
    std::array<std::int64_t, 3> facet{};
    for (std::size_t i = 0; i < dim_; ++i)
      facet[i] = in == 1 ? crossing(inside[0], outside[i % out]) : crossing(inside[i % in], outside[0]);
    add_facet(facet, outwards);
  }

  /// Number of the surface point on the edge between two grid nodes; adds the point if it is new.
  std::int64_t crossing(std::size_t inside, std::size_t outside) {
    const auto [found, isnew] =
        points_.try_emplace({inside, outside}, static_cast<std::int64_t>(points_.size()));
    if (isnew) {
      const double part = levels_[inside] / (levels_[inside] - levels_[outside]);
      const Point low = position(inside);
      add_point(surface_, dim_, closer(along(low, part, from(low, position(outside)))));
    }
    return found->second;
  }

  /// Moves a point near the surface onto the tangent plane of the obstacle there.
  [[nodiscard]] Point closer(const Point& x) const {
    try {
      const Obstacle::Plane plane = obstacle_.at(x.data(), place_);
      return std::abs(plane.height) < width_ ? along(x, -plane.height, plane.normal) : x;
    } catch (const UserError&) { // no normal there
      return x;
    }
  }

  void add_facet(std::array<std::int64_t, 3> facet, const Point& outwards) {
    std::array<Point, 3> x{};
    for (std::size_t i = 0; i < dim_; ++i)
      std::copy_n(&surface_.points[dim_ * static_cast<std::size_t>(facet[i])], dim_, x[i].begin());
    const Point side = from(x[0], x[1]),
                normal = dim_ == 2 ? Point{-side[1], side[0], 0} : cross(side, from(x[0], x[2]));
    if (dot(normal, outwards) < 0)
      std::swap(facet[0], facet[1]);
    surface_.facets.insert(surface_.facets.end(), facet.begin(),
                           facet.begin() + static_cast<std::ptrdiff_t>(dim_));
  }

  const Obstacle& obstacle_;
  const Obstacle::Place& place_;
  std::size_t dim_;
  const Box& box_;
  double width_ = 0; ///< width of a grid cell, m
  std::array<std::size_t, 3> count_{1, 1, 1};
  std::vector<double> levels_; ///< levels at the grid's nodes; the first coordinate varies fastest
  std::map<std::pair<std::size_t, std::size_t>, std::int64_t> points_; ///< numbers, by inner and outer node
  ObstacleSurface surface_;
};

} // namespace

ObstacleSurface surface_within(const Obstacle& obstacle, const Obstacle::Place& place, int dim,
                               const Box& box, int cells) {
  const auto components = static_cast<std::size_t>(dim);
  Box seen = box;
  if (obstacle.axisymmetric())
    seen.low[0] = std::max(seen.low[0], 0.0);
  if (!obstacle.curved())
    return flat(obstacle, place, components, seen);
  const std::optional<std::array<Point, 2>> extent = obstacle.extent(place);
  bool whole = extent.has_value();
  for (std::size_t c = 0; extent && c < components; ++c) {
    constexpr double margin = 0.05;                     // part of the radius
    const bool cut = obstacle.axisymmetric() && c == 0; // at the axis
    const double low = cut ? 0 : (*extent)[0][c] - margin * place.radius,
                 high = (*extent)[1][c] + margin * place.radius;
    if (high - low <= much_larger * box.longest_side()) {
      seen.low[c] = low;
      seen.high[c] = high;
      continue;
    }
    seen.low[c] = std::max(low, box.low[c]);
    seen.high[c] = std::min(high, box.high[c]);
    whole = false;
    if (seen.low[c] >= seen.high[c])
      return {};
  }
  ObstacleSurface surface = Contour(obstacle, place, components, seen, cells)();
  surface.whole = whole;
  return surface;
}

} // namespace signorini::contact
