// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/coherence.h"
#include "base/collective.h"
#include <algorithm>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/mesh/Mesh.h>
#include <dolfinx/mesh/utils.h>
#include <map>
#include <numeric>
#include <span>

namespace signorini::fem {

namespace {

/// Disjoint sets of the numbers 0 … n − 1 (union-find); initially each number is a set of its own.
class Sets {
public:
  explicit Sets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }

  [[nodiscard]] std::size_t first(std::size_t i) { // least number of the set of i
    while (parent_[i] != i)
      i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(std::size_t i, std::size_t j) {
    i = first(i), j = first(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

private:
  std::vector<std::size_t> parent_;
};

std::int64_t sum(MPI_Comm comm, std::int64_t mine) {
  MPI_Allreduce(MPI_IN_PLACE, &mine, 1, MPI_INT64_T, MPI_SUM, comm);
  return mine;
}

/// Facets of a group that this rank owns. Each facet has one owner, so that sums over the ranks count it
/// once.
std::vector<std::int32_t> owned_facets(const mesh::Mesh& mesh, const std::string& group,
                                       const std::string& key) {
  std::vector<std::int32_t> facets = mesh.facets(group, key);
  const std::int32_t owned = mesh.dolfinx()->topology()->index_map(mesh.dim() - 1)->size_local();
  std::erase_if(facets, [&](std::int32_t facet) { return facet >= owned; });
  return facets;
}

/// Global numbers of this rank's nodes, first the owned ones, then the ghosts.
std::vector<std::int64_t> global_nodes(const Space& space) {
  const auto map = space.dolfinx()->dofmap()->index_map;
  std::vector<std::int32_t> local(static_cast<std::size_t>(map->size_local() + map->num_ghosts()));
  std::iota(local.begin(), local.end(), 0);
  std::vector<std::int64_t> global(local.size());
  map->local_to_global(local, global);
  return global;
}

} // namespace

ConnectedParts connected_parts(const Space& space) {
  const auto dofmap = space.dolfinx()->dofmap();
  const std::vector<std::int64_t> global = global_nodes(space);
  Sets here(global.size());
  for (std::int32_t cell : space.mesh().owned_cells()) {
    const auto nodes = dofmap->cell_dofs(cell);
    for (std::int32_t node : nodes)
      here.unite(static_cast<std::size_t>(nodes[0]), static_cast<std::size_t>(node));
  }
  // Local sets are named by the global number of their first node; those that share a node are joined.
  using Pair = std::array<std::int64_t, 2>;
  const auto owned = static_cast<std::size_t>(space.owned_nodes());
  std::vector<Pair> joined;
  std::vector<std::int64_t> ghosts(global.begin() + static_cast<std::ptrdiff_t>(owned), global.end());
  for (std::size_t i = 0; i < global.size(); ++i)
    if (i >= owned || here.first(i) == i)
      joined.push_back({global[i], global[here.first(i)]});
  ghosts = gather(space.comm(), ghosts);
  const std::int64_t begin = space.first_dof() / space.dim();
  for (std::int64_t ghost : ghosts)
    if (ghost >= begin && ghost < begin + static_cast<std::int64_t>(owned))
      joined.push_back({ghost, global[here.first(static_cast<std::size_t>(ghost - begin))]});
  joined = gather(space.comm(), joined);
  std::map<std::int64_t, std::size_t> number;
  for (const Pair& pair : joined)
    for (std::int64_t node : pair)
      number.emplace(node, number.size());
  Sets all(number.size());
  for (const auto& [a, b] : joined)
    all.unite(number.at(a), number.at(b));
  ConnectedParts parts;
  std::vector<int> of_set(number.size());
  for (std::size_t i = 0; i < number.size(); ++i)
    of_set[i] = all.first(i) == i ? parts.count++ : of_set[all.first(i)];
  for (std::size_t i = 0; i < owned; ++i)
    parts.of_node.push_back(of_set[number.at(global[here.first(i)])]);
  return parts;
}

std::int64_t inner_facets(const mesh::Mesh& mesh, const std::string& group, const std::string& key) {
  std::vector<std::int32_t> outer = dolfinx::mesh::exterior_facet_indices(*mesh.dolfinx()->topology());
  std::ranges::sort(outer);
  const std::vector<std::int32_t> facets = owned_facets(mesh, group, key);
  return sum(mesh.comm(), std::ranges::count_if(
                              facets, [&](std::int32_t f) { return !std::ranges::binary_search(outer, f); }));
}

namespace {

/// Returns one cell of each facet, by local index.
std::vector<std::int32_t> cells_of(const Space& space, const std::vector<std::int32_t>& facets) {
  const auto cells = space.mesh().dolfinx()->topology()->connectivity(space.dim() - 1, space.dim());
  std::vector<std::int32_t> found;
  for (const std::int32_t facet : facets)
    found.push_back(cells->links(facet).front());
  return found;
}

/// Local node numbers of each facet.
std::vector<std::vector<std::int32_t>> nodes_of(const Space& space, const std::vector<std::int32_t>& facets) {
  const auto of_cell = space.mesh().dolfinx()->topology()->connectivity(space.dim(), space.dim() - 1);
  const auto dofmap = space.dolfinx()->dofmap();
  const auto closure =
      dofmap->element_dof_layout().entity_closure_dofs_all()[static_cast<std::size_t>(space.dim()) - 1];
  const std::vector<std::int32_t> cells = cells_of(space, facets);
  std::vector<std::vector<std::int32_t>> nodes(facets.size());
  for (std::size_t i = 0; i < facets.size(); ++i) {
    const auto around = of_cell->links(cells[i]);
    const auto which = static_cast<std::size_t>(std::ranges::find(around, facets[i]) - around.begin());
    for (const int dof : closure.at(which))
      nodes[i].push_back(dofmap->cell_dofs(cells[i])[static_cast<std::size_t>(dof)]);
  }
  return nodes;
}

} // namespace

std::int64_t facets_among(const Space& space, const std::string& group, const std::string& key,
                          const std::vector<PetscInt>& first_dofs) {
  const std::vector<std::int64_t> global = global_nodes(space);
  const auto among = [&](std::int32_t node) {
    return std::ranges::binary_search(
        first_dofs, static_cast<PetscInt>(global[static_cast<std::size_t>(node)] * space.dim()));
  };
  std::int64_t count = 0;
  for (const auto& nodes : nodes_of(space, owned_facets(space.mesh(), group, key)))
    count += std::ranges::all_of(nodes, among);
  return sum(space.comm(), count);
}

std::vector<OutwardNormal> outward_normals(const Space& space) {
  const auto& mesh = *space.mesh().dolfinx();
  const int dim = space.dim();
  const std::vector<std::int64_t> global = global_nodes(space);
  const std::vector<std::int32_t> facets = dolfinx::mesh::exterior_facet_indices(*mesh.topology()),
                                  cells = cells_of(space, facets);
  const std::vector<std::vector<std::int32_t>> nodes = nodes_of(space, facets);
  const std::vector<double> normals = dolfinx::mesh::cell_normals(mesh, dim - 1, std::span(facets)),
                            on = dolfinx::mesh::compute_midpoints(mesh, dim - 1, std::span(facets)),
                            within = dolfinx::mesh::compute_midpoints(mesh, dim, std::span(cells));
  std::vector<OutwardNormal> found;
  for (std::size_t i = 0; i < facets.size(); ++i) {
    std::array<double, 3> n{};
    double outward = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      n[c] = normals[3 * i + c];
      outward += n[c] * (on[3 * i + c] - within[3 * i + c]);
    }
    if (outward < 0)
      n = {-n[0], -n[1], -n[2]};
    for (const std::int32_t node : nodes[i])
      found.push_back({static_cast<PetscInt>(global[static_cast<std::size_t>(node)] * dim), n});
  }
  return found;
}

} // namespace signorini::fem
