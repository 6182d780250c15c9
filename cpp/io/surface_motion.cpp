// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/surface_motion.h"
#include "base/error.h"
#include <algorithm>
#include <array>

namespace signorini::io {

namespace {

using contact::Box;
using contact::Obstacle;
using contact::ObstacleSurface;

/// Number of cells along the longest side of the box that resolve a curved surface, in the plane and in
/// space. fine: for surfaces written once; coarse: for surfaces written at every time.
constexpr int fine[] = {120, 24}, coarse[] = {60, 16};

/// Box, in the obstacle's frame at t = 0, that contains the box `shown` at all times.
Box swept(const Obstacle& obstacle, const Box& shown, std::span<const double> times) {
  Box all = shown;
  if (!obstacle.moves())
    return all;
  const Obstacle::Place start = obstacle.place(0);
  for (const double t : times) {
    const Obstacle::Place place = obstacle.place(t);
    all.include({obstacle.carried(shown.low.data(), place, start),
                 obstacle.carried(shown.high.data(), place, start)});
  }
  return all;
}

/// Motion of the surface of an obstacle that keeps its shape.
SurfaceMotion carried(const Obstacle& obstacle, std::size_t dim, const Box& shown,
                      std::span<const double> times) {
  const Obstacle::Place start = obstacle.place(0);
  SurfaceMotion motion;
  motion.surface =
      surface_within(obstacle, start, static_cast<int>(dim), swept(obstacle, shown, times), fine[dim - 2]);
  if (!obstacle.moves())
    return motion;
  const std::vector<double>& points = motion.surface.points;
  for (const double t : times) {
    const Obstacle::Place place = obstacle.place(t);
    for (std::size_t i = 0; i < points.size(); i += dim) {
      std::array<double, 3> x{};
      std::copy_n(&points[i], dim, x.begin());
      const std::array<double, 3> now = obstacle.carried(x.data(), start, place);
      for (std::size_t c = 0; c < dim; ++c)
        motion.displacement.push_back(now[c] - x[c]);
    }
  }
  return motion;
}

/// Vector from the surface at t = 0 to the point x, to first order; zero where the surface has no normal.
std::array<double, 3> way_from_start(const Obstacle& obstacle, const double* x) {
  try {
    const Obstacle::Plane plane = obstacle.at(x);
    std::array<double, 3> way = plane.normal;
    for (double& part : way)
      part *= plane.height;
    return way;
  } catch (const UserError&) {
    return {};
  }
}

/// Motion of the surface of an obstacle that changes its shape: a new surface for each time.
SurfaceMotion renewed(const Obstacle& obstacle, std::size_t dim, const Box& shown,
                      std::span<const double> times) {
  SurfaceMotion motion{.surface = {}, .displacement = {}, .first_point = {0}, .first_facet = {0}};
  ObstacleSurface& all = motion.surface;
  for (const double t : times) {
    const ObstacleSurface now =
        surface_within(obstacle, obstacle.place(t), static_cast<int>(dim), shown, coarse[dim - 2]);
    for (std::size_t i = 0; i < now.points.size(); i += dim) {
      std::array<double, 3> x{};
      std::copy_n(&now.points[i], dim, x.begin());
      const std::array<double, 3> way = way_from_start(obstacle, x.data());
      for (std::size_t c = 0; c < dim; ++c) {
        all.points.push_back(x[c] - way[c]);
        motion.displacement.push_back(way[c]);
      }
    }
    all.facets.insert(all.facets.end(), now.facets.begin(), now.facets.end());
    motion.first_point.push_back(static_cast<std::int64_t>(all.points.size() / dim));
    motion.first_facet.push_back(static_cast<std::int64_t>(all.facets.size() / dim));
  }
  return motion;
}

/// Motion of the surface of an obstacle with mass.
SurfaceMotion moved(const Obstacle& obstacle, const contact::RigidMotion& rigid, std::size_t dim,
                    const Box& shown, const Places& places) {
  Box swept = shown;
  for (const contact::RigidMotion::Place& place : places) {
    Box back = shown;
    for (std::size_t c = 0; c < dim; ++c) {
      back.low[c] -= place.translation[c];
      back.high[c] -= place.translation[c];
    }
    swept.include(back);
  }
  SurfaceMotion motion;
  motion.surface = surface_within(obstacle, obstacle.place(0), static_cast<int>(dim), swept, fine[dim - 2]);
  const std::vector<double>& points = motion.surface.points;
  for (const contact::RigidMotion::Place& place : places)
    for (std::size_t i = 0; i < points.size(); i += dim) {
      std::array<double, 3> x{};
      std::copy_n(&points[i], dim, x.begin());
      const std::array<double, 3> way = rigid.displacement(place, x.data());
      motion.displacement.insert(motion.displacement.end(), way.begin(),
                                 way.begin() + static_cast<std::ptrdiff_t>(dim));
    }
  return motion;
}

} // namespace

SurfaceMotion surface_motion(const contact::ContactPairs& pairs, int i, const Box& shown,
                             std::span<const double> times, const Places& places) {
  const auto dim = static_cast<std::size_t>(pairs.dim());
  const Obstacle& obstacle = *pairs.shape(i);
  if (const contact::RigidMotion* rigid = pairs.rigid(i))
    return moved(obstacle, *rigid, dim, shown, places);
  return !obstacle.moves() || obstacle.keeps_shape() ? carried(obstacle, dim, shown, times)
                                                     : renewed(obstacle, dim, shown, times);
}

} // namespace signorini::io
