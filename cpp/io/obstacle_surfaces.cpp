// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/obstacle_surfaces.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/hdf5.h"
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <fmt/format.h>
#include <string>

namespace signorini::io {
namespace {

using contact::Box;
using contact::Obstacle;
using contact::ObstacleSurface;

constexpr double around = 0.3; ///< margin shown around the box of the body, relative to its longest side
/// Number of cells along the longest side of the box that resolve a curved surface, in the plane and in
/// space. fine: for surfaces written once; coarse: for surfaces written at every time.
constexpr int fine[] = {120, 24}, coarse[] = {60, 16};

/// Motion of a surface: points of the surface at t = 0, and their displacements.
struct Motion {
  ObstacleSurface surface;          ///< one surface; if the shape changes, the surfaces of all times
  std::vector<double> displacement; ///< (times × n × dim); if the shape changes, (n × dim); m; empty at rest
  /// First point and first facet of each time, with the end; empty unless the shape changes.
  std::vector<std::int64_t> first_point, first_facet;
};

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
Motion carried(const Obstacle& obstacle, std::size_t dim, const Box& shown, std::span<const double> times) {
  const Obstacle::Place start = obstacle.place(0);
  Motion motion;
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
Motion renewed(const Obstacle& obstacle, std::size_t dim, const Box& shown, std::span<const double> times) {
  Motion motion{.surface = {}, .displacement = {}, .first_point = {0}, .first_facet = {0}};
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
Motion moved(const Obstacle& obstacle, const contact::RigidMotion& rigid, std::size_t dim, const Box& shown,
             const Places& places) {
  Box swept = shown;
  for (const contact::RigidMotion::Place& place : places) {
    Box back = shown;
    for (std::size_t c = 0; c < dim; ++c) {
      back.low[c] -= place.translation[c];
      back.high[c] -= place.translation[c];
    }
    swept.include(back);
  }
  Motion motion;
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

/// The candidates of an obstacle, for the undeformed body at t = 0.
struct Candidates {
  std::vector<double> gap;    ///< gap of each candidate, m
  std::vector<double> normal; ///< outward normals of the obstacle (candidates × dim)
};

Candidates candidates_of(const contact::ContactPairs& pairs, int obstacle) {
  const auto dim = static_cast<std::size_t>(pairs.dim());
  Candidates found;
  for (std::size_t i = 0; i < pairs.obstacles().size(); ++i)
    if (pairs.obstacles()[i] == obstacle) {
      found.gap.push_back(pairs.psi()[i]);
      for (std::size_t c = 0; c < dim; ++c)
        found.normal.push_back(0 - pairs.normals()[dim * i + c]); // 0 − 0 is no −0
    }
  return found;
}

/// Whether all normals are equal up to rounding.
bool parallel(const Candidates& candidates, std::size_t dim) {
  constexpr double rounding = 1e-9;
  for (std::size_t i = 0; i < candidates.normal.size(); ++i)
    if (std::abs(candidates.normal[i] - candidates.normal[i % dim]) > rounding)
      return false;
  return true;
}

/// Writes an obstacle, or no points of a surface that is a part of the body. `flat`: whether it is a plane.
bool write(hid_t file, const std::string& name, bool flat, std::size_t dim, const Motion& motion,
           const Candidates& candidates, std::size_t times) {
  const Hdf5Handle layout = plain_layout(), group = make_group(file, name.c_str());
  const auto put = [&](const char* dataset, const std::vector<hsize_t>& shape, const auto& values) {
    return write_whole(group, dataset, shape, values.data(), layout);
  };
  const std::size_t points = motion.surface.points.size() / dim, facets = motion.surface.facets.size() / dim;
  const std::vector<std::int64_t> plane{flat}, whole{motion.surface.whole};
  bool good = group && put("points", {points, dim}, motion.surface.points) &&
              put("facets", {facets, dim}, motion.surface.facets) && put("flat", {1}, plane) &&
              put("whole", {1}, whole) && put("gap", {candidates.gap.size()}, candidates.gap) &&
              put("normal", {candidates.gap.size(), dim}, candidates.normal);
  if (!motion.first_point.empty())
    good = good && put("displacement", {points, dim}, motion.displacement) &&
           put("first_point", {times + 1}, motion.first_point) &&
           put("first_facet", {times + 1}, motion.first_facet);
  else if (!motion.displacement.empty())
    good = good && put("displacement", {times, points, dim}, motion.displacement);
  return good;
}

} // namespace

void write_obstacle_surfaces(const OutputFolder& folder, const contact::ContactPairs& pairs,
                             std::span<const double> times, const Box& body,
                             const std::vector<Places>& places) {
  constexpr const char* file_name = "surfaces.h5";
  const auto dim = static_cast<std::size_t>(pairs.dim());
  Box shown = body;
  for (std::size_t c = 0; c < dim; ++c) {
    shown.low[c] -= around * body.longest_side();
    shown.high[c] += around * body.longest_side();
  }
  on_root(pairs.comm(), [&] {
    errno = 0;
    const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    Hdf5Handle file = create_hdf5(folder.staged(file_name), H5F_ACC_TRUNC, access);
    bool good = static_cast<bool>(file);
    for (int i = 0; good && i < pairs.obstacle_count(); ++i) {
      if (pairs.surfaces(i)) {
        const Candidates candidates = candidates_of(pairs, i);
        good =
            write(file, std::to_string(i + 1), parallel(candidates, dim), dim, {}, candidates, times.size());
        continue;
      }
      const Obstacle& obstacle = *pairs.shape(i);
      const contact::RigidMotion* rigid = pairs.rigid(i);
      const Motion motion = rigid ? moved(obstacle, *rigid, dim, shown, places[static_cast<std::size_t>(i)])
                            : !obstacle.moves() || obstacle.keeps_shape()
                                ? carried(obstacle, dim, shown, times)
                                : renewed(obstacle, dim, shown, times);
      good = write(file, std::to_string(i + 1), !obstacle.curved(), dim, motion, candidates_of(pairs, i),
                   times.size());
    }
    good = good && write_whole(file, "times", {times.size()}, times.data(), plain_layout());
    if (!(file.finish() && good))
      throw OutputFailure(
          fmt::format("{}: cannot be written ({})", (folder.path() / file_name).string(), hdf5_failure()));
  });
}

} // namespace signorini::io
