// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/refinement.h"
#include "base/dolfinx_versions.h"
#include "mesh/distribution.h"
#include "mesh/facets.h"
#include "mesh/raw_mesh.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <dolfinx/mesh/Mesh.h>
#include <dolfinx/mesh/utils.h>
#include <dolfinx/refinement/plaza.h>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace signorini::mesh {
namespace {

using Coordinates = std::array<double, 3>;

double distance(const Coordinates& a, const Coordinates& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// Returns the size at the node of a field that is nearest to a given point.
class NearestSize {
public:
  explicit NearestSize(const SizeField& field) {
    for (std::size_t i = 0; i < field.sizes.size(); ++i) {
      const double* x = &field.points[3 * i];
      nodes_.emplace(x[0], std::pair(Coordinates{x[0], x[1], x[2]}, field.sizes[i]));
    }
  }

  double operator()(const Coordinates& x) const {
    double nearest = std::numeric_limits<double>::infinity(), size = 0;
    const auto look = [&](const auto& node) {
      if (std::abs(node.first - x[0]) > nearest)
        return false;
      const auto& [point, there] = node.second;
      if (const double away = distance(point, x); away < nearest)
        nearest = away, size = there;
      return true;
    };
    const auto middle = nodes_.lower_bound(x[0]);
    for (auto node = middle; node != nodes_.end() && look(*node); ++node)
      ;
    for (auto node = std::make_reverse_iterator(middle); node != nodes_.rend() && look(*node); ++node)
      ;
    return size;
  }

private:
  std::multimap<double, std::pair<Coordinates, double>> nodes_; ///< x → position and size of a node
};

/// One round of refinement: divides the edges that are too long, and further edges where conformity requires
/// it.
class Division {
public:
  explicit Division(const RawMesh& raw)
      : raw_(raw), dim_(static_cast<std::size_t>(raw.dim)), mesh_(distributed(MPI_COMM_SELF, raw, raw.dim)),
        topology_(*mesh_->topology_mutable()) {
    for (int d = 1; d < raw.dim; ++d)
      topology_.create_entities(d);
    topology_.create_connectivity(1, raw.dim);
    topology_.create_connectivity(raw.dim, 1);
    topology_.create_connectivity(raw.dim - 1, raw.dim);
    topology_.create_connectivity(raw.dim, raw.dim - 1);
  }

  /// Local indices of the edges that are too long for the sizes of a field.
  [[nodiscard]] std::vector<std::int32_t> too_long(const NearestSize& size) const {
    const std::vector<std::int64_t> ends = nodes(1);
    std::vector<std::int32_t> edges;
    for (std::size_t edge = 0; 2 * edge < ends.size(); ++edge) {
      const Coordinates a = point(ends[2 * edge]), b = point(ends[2 * edge + 1]);
      const Coordinates middle{(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
      if (distance(a, b) > std::sqrt(2.0) * size(middle))
        edges.push_back(static_cast<std::int32_t>(edge));
    }
    return edges;
  }

  [[nodiscard]] RawMesh divided(const std::vector<std::int32_t>& edges) const {
    const auto [cells, points, shape, parents, facets] =
        dolfinx::refinement::plaza::compute_refinement_data<double>(
            *mesh_, edges, dolfinx::refinement::Option::parent_cell_and_facet);
    RawMesh fine;
    fine.dim = raw_.dim;
    fine.other_groups = raw_.other_groups;
    fine.unusable = raw_.unusable;
    fine.notes = raw_.notes;
    for (std::size_t row = 0; row < shape[0]; ++row)
      for (std::size_t c = 0; c < 3; ++c)
        fine.points.push_back(c < shape[1] ? points[row * shape[1] + c] : 0);
    // In the order of their parents in the file, so that parts stay ranges.
    const std::vector<std::int64_t>& rows = topology_.original_cell_index.front();
    const auto parent = [&](std::size_t child) { return static_cast<std::size_t>((*parents)[child]); };
    std::vector<std::size_t> order(parents->size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](std::size_t child) { return rows[parent(child)]; });
    std::vector<std::int64_t> before(raw_.cells.size() / (dim_ + 1) + 1); // children of cells before each
    for (const std::size_t child : order) {
      const auto corners = cells.links(static_cast<int>(child));
      fine.cells.insert(fine.cells.end(), corners.begin(), corners.end());
      ++before[static_cast<std::size_t>(rows[parent(child)]) + 1];
    }
    std::partial_sum(before.begin(), before.end(), before.begin());
    for (const auto& [name, ranges] : raw_.parts)
      for (const std::int64_t row : ranges)
        fine.parts[name].push_back(before[static_cast<std::size_t>(row)]);
    add_facets(cells, *parents, *facets, fine);
    return fine;
  }

private:
  [[nodiscard]] Coordinates point(std::int64_t row) const {
    const double* x = &raw_.points[3 * static_cast<std::size_t>(row)];
    return {x[0], x[1], x[2]};
  }

  /// Rows of the corners of all edges (d = 1) or facets (d = dim − 1) in the points of the mesh.
  [[nodiscard]] std::vector<std::int64_t> nodes(int d) const {
    std::vector<std::int32_t> all(static_cast<std::size_t>(topology_.index_map(d)->size_local()));
    std::iota(all.begin(), all.end(), 0);
    const std::vector<std::int32_t> local =
        dolfinx_versions::corners(*mesh_, d, std::span<const std::int32_t>(all));
    const std::vector<std::int64_t>& row = mesh_->geometry().input_global_indices();
    std::vector<std::int64_t> found;
    for (const std::int32_t node : local)
      found.push_back(row[static_cast<std::size_t>(node)]);
    return found;
  }

  /// Adds the boundary groups to the refined mesh: a facet is in the groups of the facet that it is a part
  /// of.
  template <class Cells>
  void add_facets(const Cells& cells, const std::vector<std::int32_t>& parents,
                  const std::vector<std::int8_t>& of_parents, RawMesh& fine) const {
    const std::vector<std::int64_t> corners = nodes(raw_.dim - 1);
    std::map<SortedNodes, std::size_t> number;
    for (std::size_t i = 0; i * dim_ < corners.size(); ++i)
      number[sorted_nodes(std::span(corners).subspan(i * dim_, dim_))] = i;
    const auto facets_of = topology_.connectivity(raw_.dim, raw_.dim - 1);
    for (const auto& [name, facets] : raw_.facets) {
      std::vector<bool> own(number.size());
      for (std::size_t i = 0; i < facets.size(); i += dim_)
        own[number.at(sorted_nodes(std::span(facets).subspan(i, dim_)))] = true;
      std::set<SortedNodes> found; // those inside the body have two cells
      for (std::size_t child = 0; child < parents.size(); ++child)
        for (std::size_t i = 0; i <= dim_; ++i) {
          const std::int8_t at = of_parents[child * (dim_ + 1) + i];
          if (at < 0 ||
              !own[static_cast<std::size_t>(facets_of->links(parents[child])[static_cast<std::size_t>(at)])])
            continue;
          std::vector<std::int64_t> facet;
          const auto own_corners = cells.links(static_cast<int>(child));
          for (std::size_t j = 0; j <= dim_; ++j)
            if (j != i)
              facet.push_back(own_corners[j]);
          found.insert(sorted_nodes(facet));
        }
      for (const SortedNodes& facet : found)
        fine.facets[name].insert(fine.facets[name].end(), facet.begin(),
                                 facet.begin() + static_cast<std::ptrdiff_t>(dim_));
    }
  }

  const RawMesh& raw_;
  std::size_t dim_;
  std::shared_ptr<dolfinx::mesh::Mesh<double>> mesh_;
  dolfinx::mesh::Topology& topology_;
};

} // namespace

RawMesh refined(RawMesh mesh, const SizeField& sizes) {
  const NearestSize size(sizes);
  constexpr int most = 30; // halvings
  for (int i = 0; i < most; ++i) {
    const Division division(mesh);
    const std::vector<std::int32_t> edges = division.too_long(size);
    if (edges.empty())
      break;
    mesh = division.divided(edges);
  }
  return mesh;
}

} // namespace signorini::mesh
