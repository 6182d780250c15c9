// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/stress_recovery.h"
#include "base/collective.h"
#include "base/dolfinx_versions.h"
#include "mesh/facets.h"
#include "mesh/simplex.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/mesh/Mesh.h>
#include <map>
#include <numbers>
#include <set>

namespace signorini::fem {

namespace {

constexpr std::size_t components = 9;

/// Number of the part of each cell that this rank owns.
std::vector<double> part_numbers(const mesh::Mesh& mesh, const std::vector<Part>& parts) {
  std::vector<double> numbers(mesh.owned_cells().size());
  for (std::size_t part = 0; part < parts.size(); ++part)
    for (const std::int32_t cell : parts[part].cells)
      numbers.at(static_cast<std::size_t>(cell)) = static_cast<double>(part);
  return numbers;
}

} // namespace

StressRecovery::StressRecovery(const Space& space, const std::vector<Part>& parts)
    : space_(space), fields_(space, parts), rest_(space.vector()) {
  std::vector<double> part;
  cells_ = mesh::gather_cells(space.mesh(), part_numbers(space.mesh(), parts), part);
  const std::size_t corners = static_cast<std::size_t>(cells_.dim) + 1;
  std::map<std::pair<std::int64_t, double>, std::size_t> rows;
  for (std::size_t i = 0; i < cells_.cells.size(); ++i)
    rows_.push_back(rows.try_emplace({cells_.cells[i], part[i / corners]}, rows.size()).first->second);
  volumes_ = mesh::volumes(cells_);
  depths_.assign(volumes_.size(), 1.0);
  for (std::size_t i = 0; space.mesh().axisymmetric() && i < cells_.cells.size(); ++i) {
    const double share =
        2 * std::numbers::pi / static_cast<double>(corners); // of the circle at the mean radius
    double& depth = depths_[i / corners];
    depth =
        (i % corners == 0 ? 0 : depth) + share * cells_.points[3 * static_cast<std::size_t>(cells_.cells[i])];
  }
  sums_.assign(volumes_.size(), 0.0);
}

std::vector<double> StressRecovery::tensors(CellField field) {
  const std::span<const double> values = fields_(field);
  return gather(space_.mesh().comm(), std::vector<double>(values.begin(), values.end()));
}

void StressRecovery::add(Vec y, double weight) {
  fields_.set(y, rest_);
  const std::vector<double> stress = tensors(CellField::stress), strain = tensors(CellField::strain);
  const std::size_t corners = static_cast<std::size_t>(cells_.dim) + 1, count = volumes_.size();
  const std::size_t nodes = rows_.empty() ? 0 : std::ranges::max(rows_) + 1;
  std::vector<double> touching(nodes), of_stress(nodes * components), of_strain(nodes * components);
  for (std::size_t cell = 0; cell < count; ++cell)
    for (std::size_t i = 0; i < corners; ++i) {
      const std::size_t node = rows_[cell * corners + i];
      touching[node] += volumes_[cell];
      for (std::size_t c = 0; c < components; ++c) {
        of_stress[node * components + c] += volumes_[cell] * stress[cell * components + c];
        of_strain[node * components + c] += volumes_[cell] * strain[cell * components + c];
      }
    }
  // ∫ of a product of functions linear on a simplex K: |K| / ((d+1)(d+2)) (Σ a_i Σ b_j + Σ a_i b_i).
  const double share = 1.0 / static_cast<double>(corners * (corners + 1));
  for (std::size_t cell = 0; cell < count; ++cell) {
    double energy = 0;
    for (std::size_t c = 0; c < components; ++c) {
      double all_a = 0, all_b = 0;
      for (std::size_t i = 0; i < corners; ++i) {
        const std::size_t node = rows_[cell * corners + i];
        const double a = of_stress[node * components + c] / touching[node] - stress[cell * components + c],
                     b = of_strain[node * components + c] / touching[node] - strain[cell * components + c];
        all_a += a, all_b += b;
        energy += a * b;
      }
      energy += all_a * all_b;
    }
    sums_[cell] += weight / 2 * depths_[cell] * volumes_[cell] * share * std::max(0.0, energy);
  }
}

namespace {

using Point = std::array<double, 3>;
using Tensor = std::array<double, 9>;

/// Cell with its nodes in global numbers, which any rank can use.
struct Cell {
  std::size_t part = 0;
  Tensor stress{};
  std::array<std::int64_t, 4> nodes{}; ///< the first dim + 1 entries are used
  std::array<Point, 4> x{};
};

/// Cells that this rank owns.
class OwnedCells {
public:
  OwnedCells(const Space& space, const std::vector<Part>& parts, std::span<const double> stress)
      : geometry_(space.dolfinx()->mesh()->geometry()), nodes_(dolfinx_versions::cell_nodes(geometry_)),
        corners_(static_cast<std::size_t>(space.dim()) + 1), owned_(space.mesh().owned_cells()),
        part_(part_numbers(space.mesh(), parts)), stress_(stress) {}

  /// Gathers the cells of all ranks for which `wanted(cell)` is true. Collective.
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
    Cell one{.part = static_cast<std::size_t>(part_[row])};
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
  std::vector<double> part_;
  std::span<const double> stress_;
};

mesh::Simplex simplex(const Cell& cell, int dim) {
  return {dim, [&](int i) { return cell.x[static_cast<std::size_t>(i)].data(); }};
}

/// Angle of a cell at its node i, as a fraction of the full angle (2π, or 4π for solid angles).
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

/// Nodes on facets that belong to only one of `cells`. For a node all of whose cells are given, this shows
/// whether it is on the boundary.
/// Facets on the axis of a body of revolution are inside the body.
std::set<std::int64_t> on_outer_facets(const std::vector<Cell>& cells, std::size_t corners,
                                       bool axisymmetric) {
  const auto dim = static_cast<std::ptrdiff_t>(corners) - 1;
  std::vector<std::int64_t> nodes;
  std::set<std::int64_t> axis, found;
  for (const Cell& cell : cells) {
    nodes.insert(nodes.end(), cell.nodes.begin(), cell.nodes.begin() + dim + 1);
    for (std::size_t i = 0; axisymmetric && i < corners; ++i)
      if (cell.x[i][0] == 0)
        axis.insert(cell.nodes[i]);
  }
  for (const mesh::Facet& facet : mesh::outer_facets(mesh::sorted_facets(static_cast<int>(dim), nodes)))
    if (!std::all_of(facet.nodes.begin(), facet.nodes.begin() + dim,
                     [&](std::int64_t node) { return axis.contains(node); }))
      found.insert(facet.nodes.begin(), facet.nodes.begin() + dim);
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
  const std::set<std::int64_t> boundary = on_outer_facets(around, corners, space.mesh().axisymmetric());
  Tensor recovered{};
  double most = -1;
  for (std::size_t i = 0; i < corners; ++i) {
    Tensor sum{};
    double volumes = 0, part_of_full = 0, stress = 0;
    for (const Cell& other : around)
      for (std::size_t j = 0; j < corners; ++j)
        if (other.nodes[j] == nodes[i]) {
          // Around a node on the axis the section shows half of the angle.
          part_of_full += (space.on_axis_of_revolution(other.x[j][0]) ? 2 : 1) * angle(other, j, corners);
          if (other.part != cell.part)
            continue;
          const double volume = simplex(other, space.dim()).abs_determinant();
          volumes += volume;
          stress += volume * von_mises(other.stress); // in a mean of tensors shear beside a load would cancel
          for (std::size_t c = 0; c < sum.size(); ++c)
            sum[c] += volume * other.stress[c];
        }
    for (std::size_t c = 0; c < sum.size(); ++c)
      recovered[c] += sum[c] / volumes / static_cast<double>(corners);
    // The angles at a smooth boundary depend on its cells; the load, clamp or contact that causes the stress
    // is where the stress is largest.
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
