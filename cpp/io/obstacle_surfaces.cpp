// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/obstacle_surfaces.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/hdf5.h"
#include "io/vtkhdf.h"
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <fmt/format.h>
#include <string>
#include <utility>

namespace signorini::io {
namespace {

using contact::Box;

constexpr double around = 0.3; ///< margin shown around the box of the body, relative to its longest side
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
bool write(hid_t file, const std::string& name, bool flat, std::size_t dim, const SurfaceMotion& motion,
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
  if (motion.renewed())
    good = good && put("displacement", {points, dim}, motion.displacement) &&
           put("first_point", {times + 1}, motion.first_point) &&
           put("first_facet", {times + 1}, motion.first_facet);
  else if (motion.moves())
    good = good && put("displacement", {times, points, dim}, motion.displacement);
  return good;
}

/// An obstacle that is no part of the body.
struct Drawn {
  int number; ///< from 1, in the scene's order
  SurfaceMotion motion;
};

/// Surfaces of all obstacles as one grid over time.
struct ObstacleGrid {
  std::vector<double> points;                 ///< (n × dim), m
  std::vector<std::int64_t> facets, obstacle; ///< (facets × dim), and the number of each facet's obstacle
  std::vector<VtkhdfGroup::Part> parts;
  std::vector<VtkhdfGroup::Time> times;
};

/// Appends an obstacle at output time k to the points and, if `with_facets`, the facets of `grid`. `part`:
/// the mesh that the obstacle extends.
void append(ObstacleGrid& grid, VtkhdfGroup::Part& part, const Drawn& drawn, std::size_t dim, std::size_t k,
            bool with_facets) {
  const SurfaceMotion& motion = drawn.motion;
  const std::vector<double>& points = motion.surface.points;
  const std::size_t first = motion.renewed() ? dim * static_cast<std::size_t>(motion.first_point[k]) : 0,
                    end = motion.renewed() ? dim * static_cast<std::size_t>(motion.first_point[k + 1])
                                           : points.size(),
                    moved = motion.renewed() ? 0 : k * points.size();
  for (std::size_t i = first; i < end; ++i)
    grid.points.push_back(points[i] + (motion.moves() ? motion.displacement[moved + i] : 0));
  if (with_facets) {
    const std::vector<std::int64_t>& facets = motion.surface.facets;
    const std::size_t from = motion.renewed() ? dim * static_cast<std::size_t>(motion.first_facet[k]) : 0,
                      to = motion.renewed() ? dim * static_cast<std::size_t>(motion.first_facet[k + 1])
                                            : facets.size();
    for (std::size_t i = from; i < to; ++i)
      grid.facets.push_back(facets[i] + static_cast<std::int64_t>(part.points));
    grid.obstacle.resize(grid.facets.size() / dim, drawn.number);
    part.cells += (to - from) / dim;
  }
  part.points += (end - first) / dim;
}

ObstacleGrid grid_of(const std::vector<Drawn>& all, std::size_t dim, std::span<const double> times) {
  const bool renewed = std::ranges::any_of(all, [](const Drawn& one) { return one.motion.renewed(); }),
             moves = std::ranges::any_of(all, [](const Drawn& one) { return one.motion.moves(); });
  ObstacleGrid grid;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const bool with_facets = k == 0 || renewed;
    VtkhdfGroup::Time now{.time = times[k]};
    if (moves)
      now.first_point = grid.points.size() / dim;
    if (renewed) {
      now.part = grid.parts.size();
      now.first_cell = grid.obstacle.size();
    }
    grid.times.push_back(now);
    if (k > 0 && !moves)
      continue;
    VtkhdfGroup::Part part{};
    for (const Drawn& one : all)
      append(grid, part, one, dim, k, with_facets);
    if (with_facets)
      grid.parts.push_back(part);
  }
  return grid;
}

bool write_grid(const std::filesystem::path& path, const ObstacleGrid& grid, std::size_t dim) {
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V110);
  Hdf5Handle file = create_hdf5(path, H5F_ACC_TRUNC, access);
  bool good = static_cast<bool>(file);
  {
    VtkhdfGroup group;
    good = good && group.create(file) && group.write_meshes(grid.parts, dim, grid.points, dim, grid.facets) &&
           group.write_cell_numbers("obstacle", grid.obstacle) && group.write_times(grid.times, {});
  }
  return file.finish() && good;
}

} // namespace

void write_obstacle_surfaces(const OutputFolder& folder, const contact::ContactPairs& pairs,
                             std::span<const double> times, const Box& body,
                             const std::vector<Places>& places, bool vtkhdf) {
  constexpr const char *surfaces = "surfaces.h5", *grid = "obstacles.vtkhdf";
  const auto dim = static_cast<std::size_t>(pairs.dim());
  Box shown = body;
  for (std::size_t c = 0; c < dim; ++c) {
    shown.low[c] -= around * body.longest_side();
    shown.high[c] += around * body.longest_side();
  }
  on_root(pairs.comm(), [&] {
    const auto guarded = [&](const char* name, auto&& write) {
      errno = 0;
      if (!write(folder.staged(name)))
        throw OutputFailure(
            fmt::format("{}: cannot be written ({})", (folder.path() / name).string(), hdf5_failure()));
    };
    std::vector<Drawn> drawn;
    guarded(surfaces, [&](const std::filesystem::path& path) {
      const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
      Hdf5Handle file = create_hdf5(path, H5F_ACC_TRUNC, access);
      bool good = static_cast<bool>(file);
      for (int i = 0; good && i < pairs.obstacle_count(); ++i) {
        const std::string name = std::to_string(i + 1);
        const Candidates candidates = candidates_of(pairs, i);
        if (pairs.surfaces(i)) {
          good = write(file, name, parallel(candidates, dim), dim, {}, candidates, times.size());
          continue;
        }
        SurfaceMotion motion = surface_motion(pairs, i, shown, times, places[static_cast<std::size_t>(i)]);
        good = write(file, name, !pairs.shape(i)->curved(), dim, motion, candidates, times.size());
        drawn.push_back({i + 1, std::move(motion)});
      }
      good = good && write_whole(file, "times", {times.size()}, times.data(), plain_layout());
      return file.finish() && good;
    });
    if (vtkhdf && !drawn.empty())
      guarded(grid, [&](const std::filesystem::path& path) {
        return write_grid(path, grid_of(drawn, dim, times), dim);
      });
  });
}

} // namespace signorini::io
