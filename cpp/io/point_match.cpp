// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/point_match.h"
#include "base/collective.h"
#include "base/dolfinx_versions.h"
#include "base/text.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/la/Vector.h>
#include <fmt/format.h>
#include <functional>
#include <map>

namespace signorini::io {

namespace {

/// Grid of cubic cells for finding equal points. The coordinates of a node in two runs agree within `near_`.
/// Cells are much larger than `near_`, so that few points lie near their sides, and so small that each
/// contains at most one node.
class Grid {
public:
  explicit Grid(const fem::Space& space) : near_(1e-10 * space.mesh().diameter()), cell_(100 * near_) {}

  using Cell = std::array<std::int64_t, 3>;

  /// Grid cell of the point x (dim) after a shift by `shift` (m) along every axis.
  [[nodiscard]] Cell cell_of(const double* x, std::size_t dim, double shift) const {
    Cell at{};
    for (std::size_t c = 0; c < dim; ++c)
      at[c] = static_cast<std::int64_t>(std::floor((x[c] + shift) / cell_ + 0.5));
    return at;
  }

  /// Calls visit(cell) for the grid cells within `near_` of the point x, until `visit` returns true.
  template <class Visit>
  void around(const double* x, std::size_t dim, Visit&& visit) const {
    const Cell low = cell_of(x, dim, -near_), high = cell_of(x, dim, near_);
    for (Cell at = low; at[0] <= high[0]; ++at[0])
      for (at[1] = low[1]; at[1] <= high[1]; ++at[1])
        for (at[2] = low[2]; at[2] <= high[2]; ++at[2])
          if (visit(at))
            return;
  }

private:
  double near_, cell_;
};

/// Returns for each point in `here` whether it coincides with another point in `all`, which contains `here`.
/// Both have `stride` numbers for each point.
std::vector<bool> ambiguous(const fem::Space& space, const std::vector<double>& here,
                            const std::vector<double>& all, std::size_t stride) {
  const Grid grid(space);
  const auto dim = static_cast<std::size_t>(space.dim());
  std::map<Grid::Cell, int> counts;
  for (std::size_t i = 0; i < all.size(); i += stride)
    ++counts[grid.cell_of(&all[i], dim, 0)];
  std::vector<bool> found;
  for (std::size_t i = 0; i < here.size(); i += stride) {
    int count = 0;
    grid.around(&here[i], dim, [&](const Grid::Cell& at) {
      const auto entry = counts.find(at);
      count += entry == counts.end() ? 0 : entry->second;
      return count > 1;
    });
    found.push_back(count > 1);
  }
  return found;
}

/// Displacement of a coincident node, relative to its distance from the mean midpoint of its cells. No other
/// node lies at the displaced point.
constexpr double inwards = 0.1;

} // namespace

std::vector<double> distinct_points(const fem::Space& space) {
  std::vector<double> points = space.points();
  const std::vector<bool> moved = ambiguous(space, points, gather(space.comm(), points), 3);
  int any = std::ranges::find(moved, true) != moved.end();
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, space.comm());
  if (!any)
    return points;
  // For each node the sum of the midpoints of its cells, and their number.
  const auto dofmap = space.dolfinx()->dofmap();
  const std::vector<double> middles = space.midpoints();
  dolfinx::la::Vector<double> sums(dofmap->index_map, 4);
  const std::span<double> sum = dolfinx_versions::entries(sums);
  std::size_t number = 0;
  for (std::int32_t cell : space.mesh().owned_cells()) {
    for (std::int32_t node : dofmap->cell_dofs(cell)) {
      const auto at = 4 * static_cast<std::size_t>(node);
      for (std::size_t c = 0; c < 3; ++c)
        sum[at + c] += middles[3 * number + c];
      ++sum[at + 3];
    }
    ++number;
  }
  sums.scatter_rev(std::plus<>{});
  for (std::size_t i = 0; i < moved.size(); ++i)
    for (std::size_t c = 0; moved[i] && c < 3; ++c)
      points[3 * i + c] += inwards * (sum[4 * i + c] / sum[4 * i + 3] - points[3 * i + c]);
  return points;
}

bool separate(std::vector<double>& points, const std::vector<std::int64_t>& cells, const fem::Space& space) {
  const auto dim = static_cast<std::size_t>(space.dim()), corners = dim + 1, n = points.size() / dim;
  const std::vector<bool> moved = ambiguous(space, points, points, dim);
  if (std::ranges::find(moved, true) == moved.end())
    return true;
  if (cells.size() % corners != 0 ||
      !std::ranges::all_of(cells, [n](std::int64_t v) { return v >= 0 && v < static_cast<std::int64_t>(n); }))
    return false;
  std::vector<double> sum(points.size(), 0.0), count(n, 0.0);
  for (std::size_t first = 0; first < cells.size(); first += corners)
    for (std::size_t c = 0; c < dim; ++c) {
      double middle = 0;
      for (std::size_t v = 0; v < corners; ++v)
        middle += points[static_cast<std::size_t>(cells[first + v]) * dim + c] / static_cast<double>(corners);
      for (std::size_t v = 0; v < corners; ++v)
        sum[static_cast<std::size_t>(cells[first + v]) * dim + c] += middle;
    }
  for (std::int64_t v : cells)
    ++count[static_cast<std::size_t>(v)];
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t c = 0; moved[i] && count[i] > 0 && c < dim; ++c)
      points[i * dim + c] += inwards * (sum[i * dim + c] / count[i] - points[i * dim + c]);
  return true;
}

std::vector<std::size_t> match_points(const fem::Space& space, const std::vector<double>& there,
                                      const std::vector<double>& here,
                                      const std::function<void(const std::string& problem)>& fail) {
  const auto dim = static_cast<std::size_t>(space.dim());
  const Grid grid(space);
  std::vector<std::size_t> numbers;
  on_all_ranks(space.comm(), [&] {
    std::map<Grid::Cell, std::size_t> known;
    for (std::size_t i = 0; i < there.size() / dim; ++i)
      if (!known.emplace(grid.cell_of(&there[i * dim], dim, 0), i).second)
        fail(fmt::format("found two points at {} m; use a mesh without coincident nodes or cells",
                         point_text(&there[i * dim], space.dim())));
    for (std::size_t i = 0; i < here.size() / 3; ++i) {
      const double* x = &here[3 * i];
      auto found = known.end();
      grid.around(x, dim, [&](const Grid::Cell& at) { return (found = known.find(at)) != known.end(); });
      if (found == known.end())
        fail(fmt::format("found no point at {} m, where this scene has one; use a run on the same mesh",
                         point_text(x, space.dim())));
      numbers.push_back(found->second);
    }
  });
  return numbers;
}

} // namespace signorini::io
