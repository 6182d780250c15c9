// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/stress_peak.h"
#include "base/collective.h"
#include "base/dolfinx_versions.h"
#include "mesh/simplex.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/mesh/Mesh.h>
#include <map>
#include <numbers>
#include <set>

namespace signorini::fem {
namespace {

using Point = std::array<double, 3>;
using Tensor = std::array<double, 9>;

/// A cell as all ranks know it.
struct Cell {
  std::size_t part = 0;
  Tensor stress{};
  std::array<std::int64_t, 4> nodes{}; ///< dim + 1 of them
  std::array<Point, 4> x{};
};

double von_mises(const Tensor& stress) {
  const double mean = (stress[0] + stress[4] + stress[8]) / 3;
  double square = 0;
  for (std::size_t c = 0; c < stress.size(); ++c)
    square += std::pow(stress[c] - (c % 4 == 0 ? mean : 0), 2);
  return std::sqrt(1.5 * square);
}

/// The cells that this rank owns.
class OwnedCells {
public:
  OwnedCells(const Space& space, const std::vector<Part>& parts, std::span<const double> stress)
      : geometry_(space.dolfinx()->mesh()->geometry()), nodes_(dolfinx_versions::cell_nodes(geometry_)),
        corners_(static_cast<std::size_t>(space.dim()) + 1), owned_(space.mesh().owned_cells()),
        part_(owned_.size()), stress_(stress) {
    for (std::size_t part = 0; part < parts.size(); ++part)
      for (const std::int32_t cell : parts[part].cells)
        part_.at(static_cast<std::size_t>(cell)) = part;
  }

  /// Those for which `wanted(cell)`, of all ranks. Collective.
  template <class Wanted>
  [[nodiscard]] std::vector<Cell> gathered(MPI_Comm comm, Wanted&& wanted) const {
    std::vector<Cell> found;
    for (const std::int32_t cell : owned_)
      if (const Cell one = of(cell); wanted(one))
        found.push_back(one);
    return gather(comm, found);
  }

private:
  [[nodiscard]] Cell of(std::int32_t cell) const {
    const auto row = static_cast<std::size_t>(cell);
    Cell one{.part = part_[row]};
    std::copy_n(&stress_[row * one.stress.size()], one.stress.size(), one.stress.begin());
    std::array<std::int32_t, 4> local{};
    for (std::size_t i = 0; i < corners_; ++i) {
      local[i] = nodes_(row, i);
      std::copy_n(&geometry_.x()[3 * static_cast<std::size_t>(local[i])], 3, one.x[i].begin());
    }
    geometry_.index_map()->local_to_global(std::span(local).first(corners_),
                                           std::span(one.nodes).first(corners_));
    return one;
  }

  const dolfinx::mesh::Geometry<double>& geometry_;
  decltype(dolfinx_versions::cell_nodes(std::declval<const dolfinx::mesh::Geometry<double>&>())) nodes_;
  std::size_t corners_;
  std::vector<std::int32_t> owned_;
  std::vector<std::size_t> part_;
  std::span<const double> stress_;
};

mesh::Simplex simplex(const Cell& cell, int dim) {
  return {dim, [&](int i) { return cell.x[static_cast<std::size_t>(i)].data(); }};
}

/// The angle of a cell at its node i, as a part of the full one.
double angle(const Cell& cell, std::size_t i, std::size_t corners) {
  std::array<Point, 3> edge{};
  std::array<double, 3> length{};
  for (std::size_t e = 0, j = 0; j < corners; ++j)
    if (j != i) {
      for (std::size_t k = 0; k < 3; ++k)
        edge[e][k] = cell.x[j][k] - cell.x[i][k];
      length[e] = std::hypot(edge[e][0], edge[e][1], edge[e][2]);
      ++e;
    }
  const auto dot = [&](std::size_t a, std::size_t b) {
    return edge[a][0] * edge[b][0] + edge[a][1] * edge[b][1] + edge[a][2] * edge[b][2];
  };
  constexpr double full = 2 * std::numbers::pi;
  if (corners == 3)
    return std::acos(std::clamp(dot(0, 1) / (length[0] * length[1]), -1.0, 1.0)) / full;
  // Van Oosterom, Strackee 1983; twice the arc tangent, of the full solid angle 4π.
  const Point& a = edge[0];
  const Point &b = edge[1], &c = edge[2];
  const double volume = std::abs(a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                                 a[2] * (b[0] * c[1] - b[1] * c[0])),
               below = length[0] * length[1] * length[2] + dot(0, 1) * length[2] + dot(0, 2) * length[1] +
                       dot(1, 2) * length[0];
  return std::atan2(volume, below) / full;
}

/// Nodes on facets of one cell alone; of a node all of whose cells are given, whether it is on the boundary.
std::set<std::int64_t> on_outer_facets(const std::vector<Cell>& cells, std::size_t corners) {
  std::map<std::vector<std::int64_t>, int> facets;
  for (const Cell& cell : cells)
    for (std::size_t out = 0; out < corners; ++out) {
      std::vector<std::int64_t> nodes;
      for (std::size_t i = 0; i < corners; ++i)
        if (i != out)
          nodes.push_back(cell.nodes[i]);
      std::ranges::sort(nodes);
      ++facets[nodes];
    }
  std::set<std::int64_t> found;
  for (const auto& [nodes, count] : facets)
    if (count == 1)
      found.insert(nodes.begin(), nodes.end());
  return found;
}

} // namespace

StressPeak stress_peak(const Space& space, const std::vector<Part>& parts, CellFields& fields) {
  StressPeak peak{.largest = fields.largest_von_mises()};
  const auto corners = static_cast<std::size_t>(space.dim()) + 1;
  const MPI_Comm comm = space.comm();
  const OwnedCells cells(space, parts, fields(CellField::stress));
  const std::vector<Cell> there = cells.gathered(comm, [&](const Cell& cell) {
    const Point xi = simplex(cell, space.dim()).reference(peak.largest.at.data());
    return std::ranges::all_of(xi, [](double one) { return one >= 0; }) && xi[0] + xi[1] + xi[2] <= 1;
  });
  if (there.empty())
    return peak;
  const Cell& cell = there.front();
  const auto nodes = std::span(cell.nodes).first(corners);
  const std::vector<Cell> around = cells.gathered(comm, [&](const Cell& other) {
    return std::ranges::find_first_of(nodes, std::span(other.nodes).first(corners)) != nodes.end();
  });
  const std::set<std::int64_t> boundary = on_outer_facets(around, corners);
  Tensor recovered{};
  double most = -1;
  for (std::size_t i = 0; i < corners; ++i) {
    Tensor sum{};
    double volumes = 0, part_of_full = 0, stress = 0;
    for (const Cell& other : around)
      for (std::size_t j = 0; j < corners; ++j)
        if (other.nodes[j] == nodes[i]) {
          part_of_full += angle(other, j, corners);
          if (other.part != cell.part)
            continue;
          const double volume = simplex(other, space.dim()).volume();
          volumes += volume;
          stress += volume * von_mises(other.stress); // of tensors shear beside a load would cancel
          for (std::size_t c = 0; c < sum.size(); ++c)
            sum[c] += volume * other.stress[c];
        }
    for (std::size_t c = 0; c < sum.size(); ++c)
      recovered[c] += sum[c] / volumes / static_cast<double>(corners);
    // Angles of a smooth boundary differ by how it is divided; the load, the clamp or the contact that makes
    // the stress is where that is largest.
    stress /= volumes;
    const bool sharper = part_of_full > std::max(reentrant, peak.angle),
               smooth = std::max(part_of_full, peak.angle) <= reentrant;
    if (boundary.contains(nodes[i]) && (sharper || (smooth && stress > most))) {
      peak.corner = cell.x[i];
      peak.angle = part_of_full;
      most = stress;
    }
  }
  peak.recovered = von_mises(recovered);
  return peak;
}

} // namespace signorini::fem
