// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/surface.h"
#include "base/collective.h"
#include <algorithm>
#include <basix/cell.h>
#include <cmath>
#include <dolfinx/fem/DofMap.h>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/mesh/Mesh.h>
#include <dolfinx/mesh/utils.h>
#include <fmt/format.h>
#include <functional>
#include <map>
#include <span>

namespace signorini::fem {

namespace {

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

} // namespace

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
  const std::vector<std::int64_t> global = space.global_nodes();
  const auto among = [&](std::int32_t node) {
    return std::ranges::binary_search(
        first_dofs, static_cast<PetscInt>(global[static_cast<std::size_t>(node)] * space.dim()));
  };
  std::int64_t count = 0;
  for (const auto& nodes : nodes_of(space, owned_facets(space.mesh(), group, key)))
    count += std::ranges::all_of(nodes, among);
  return sum(space.comm(), count);
}

namespace {

/// Unit normals of facets out of the body. A facet inside the body gets the normal out of its first cell.
std::vector<std::array<double, 3>> normals_of(const Space& space, const std::vector<std::int32_t>& facets) {
  const auto& mesh = *space.mesh().dolfinx();
  const int dim = space.dim();
  const std::vector<std::int32_t> cells = cells_of(space, facets);
  const std::vector<double> normals = dolfinx::mesh::cell_normals(mesh, dim - 1, std::span(facets)),
                            on = dolfinx::mesh::compute_midpoints(mesh, dim - 1, std::span(facets)),
                            within = dolfinx::mesh::compute_midpoints(mesh, dim, std::span(cells));
  std::vector<std::array<double, 3>> outward(facets.size());
  for (std::size_t i = 0; i < facets.size(); ++i) {
    double along = 0;
    for (std::size_t c = 0; c < 3; ++c)
      along += normals[3 * i + c] * (on[3 * i + c] - within[3 * i + c]);
    for (std::size_t c = 0; c < 3; ++c)
      outward[i][c] = along < 0 ? -normals[3 * i + c] : normals[3 * i + c];
  }
  return outward;
}

} // namespace

std::vector<OutwardNormal> outward_normals(const Space& space) {
  const std::vector<std::int64_t> global = space.global_nodes();
  const std::vector<std::int32_t> facets =
      dolfinx::mesh::exterior_facet_indices(*space.mesh().dolfinx()->topology());
  const std::vector<std::vector<std::int32_t>> nodes = nodes_of(space, facets);
  const std::vector<std::array<double, 3>> normals = normals_of(space, facets);
  std::vector<OutwardNormal> found;
  for (std::size_t i = 0; i < facets.size(); ++i)
    for (const std::int32_t node : nodes[i])
      found.push_back(
          {static_cast<PetscInt>(global[static_cast<std::size_t>(node)] * space.dim()), normals[i]});
  return found;
}

std::vector<SurfaceEdge> edges_on(const Space& space, const std::string& group, const std::string& key) {
  const auto topology = space.mesh().dolfinx()->topology();
  const int dim = topology->dim();
  const auto cell = dolfinx::mesh::cell_type_to_basix_type(topology->cell_type());
  const std::vector<std::vector<std::vector<int>>> corners = basix::cell::topology(cell);
  const auto cells_of = topology->connectivity(dim - 1, dim),
             facets_of = topology->connectivity(dim, dim - 1);
  const auto dofmap = space.dolfinx()->dofmap();
  const auto node_of = [&](int entity_dim, int entity) {
    return dofmap->element_dof_layout().entity_dofs(entity_dim, entity).front();
  };
  std::vector<SurfaceEdge> found;
  for (std::int32_t facet : space.mesh().facets(group, key)) {
    const std::int32_t owner = cells_of->links(facet).front();
    const auto own = facets_of->links(owner);
    const auto number = static_cast<std::size_t>(std::ranges::find(own, facet) - own.begin());
    const std::vector<int>& facet_corners = corners[dim - 1][number];
    for (std::size_t edge = 0; edge < corners[1].size(); ++edge) {
      const std::vector<int>& ends = corners[1][edge];
      if (!std::ranges::all_of(
              ends, [&](int end) { return std::ranges::find(facet_corners, end) != facet_corners.end(); }))
        continue;
      const auto nodes = dofmap->cell_dofs(owner);
      const std::array<std::int32_t, 3> local{nodes[node_of(1, static_cast<int>(edge))],
                                              nodes[node_of(0, ends[0])], nodes[node_of(0, ends[1])]};
      std::array<std::int64_t, 3> global{};
      dofmap->index_map->local_to_global(local, global);
      // in the same order for every facet at the edge
      found.push_back({global[0], {std::min(global[1], global[2]), std::max(global[1], global[2])}});
    }
  }
  found = gather(space.comm(), found);
  std::ranges::sort(found);
  const auto twice = std::ranges::unique(found);
  found.erase(twice.begin(), twice.end());
  return found;
}

namespace {

/// Appends the midpoints of the edges of a surface of degree 2, and sets those of the facets.
void add_midpoints(int dim, const std::vector<SurfaceEdge>& edges, const std::map<PetscInt, int>& vertex,
                   SurfaceMesh& surface) {
  std::map<std::array<int, 2>, int> number; // of the node between two vertices
  for (const SurfaceEdge& edge : edges) {
    SurfaceMesh::Midpoint midpoint{.node = {.x = {}, .first_dof = static_cast<PetscInt>(edge.middle * dim)},
                                   .ends = {}};
    bool both = true; // not on the axis of a body of revolution
    for (std::size_t end = 0; end < 2; ++end) {
      const auto found = vertex.find(static_cast<PetscInt>(edge.ends[end] * dim));
      both = both && found != vertex.end();
      midpoint.ends[end] = found != vertex.end() ? found->second : -1;
    }
    if (!both)
      continue;
    std::ranges::sort(midpoint.ends);
    for (const int end : midpoint.ends)
      for (std::size_t c = 0; c < 3; ++c)
        midpoint.node.x[c] += surface.vertices[static_cast<std::size_t>(end)].x[c] / 2;
    surface.midpoints.push_back(midpoint);
  }
  std::ranges::sort(surface.midpoints, {}, &SurfaceMesh::Midpoint::ends); // as the vertices are ordered
  for (std::size_t i = 0; i < surface.midpoints.size(); ++i)
    number[surface.midpoints[i].ends] = static_cast<int>(surface.vertices.size() + i);
  const auto corners = static_cast<std::size_t>(dim);
  for (SurfaceMesh::Facet& facet : surface.facets)
    for (std::size_t edge = 0; edge < corners * (corners - 1) / 2; ++edge) {
      const int a = facet.vertices[edge], b = facet.vertices[(edge + 1) % corners];
      facet.midpoints[edge] = number.at({std::min(a, b), std::max(a, b)});
    }
}

} // namespace

SurfaceMesh surface_mesh(const Space& space, const std::string& group, const std::string& key) {
  if (inner_facets(space.mesh(), group, key) > 0)
    throw UserError(fmt::format("{}: the group \"{}\" has facets inside the body. Choose a group of its "
                                "boundary; parts in contact must not share nodes",
                                key, group));
  const int dim = space.dim();
  std::vector<SurfaceEdge> edges;
  if (space.degree() > 1)
    edges = edges_on(space, group, key);
  const auto at_midpoint = [&](int node) {
    return std::ranges::binary_search(edges, space.first_dof() / dim + node, {}, &SurfaceEdge::middle);
  };
  std::vector<SurfaceMesh::Vertex> vertices;
  for (const int node : space.nodes_on(group, key, true)) {
    if (at_midpoint(node))
      continue;
    const double* x = &space.points()[3 * static_cast<std::size_t>(node)];
    vertices.push_back({{x[0], x[1], x[2]}, space.first_dof() + node * dim});
  }
  SurfaceMesh made{.vertices = gather(space.comm(), vertices), .midpoints = {}, .facets = {}};
  // Coordinates of a node may differ in the last digits from one partition of the mesh to another.
  const double unit = 1e-10 * space.mesh().diameter();
  const auto place = [&](double coordinate) { return std::llround(coordinate / unit); };
  std::ranges::sort(made.vertices, {}, [&](const SurfaceMesh::Vertex& vertex) {
    return std::array<std::int64_t, 4>{place(vertex.x[0]), place(vertex.x[1]), place(vertex.x[2]),
                                       vertex.first_dof};
  });
  std::map<PetscInt, int> number;
  for (std::size_t i = 0; i < made.vertices.size(); ++i)
    number[made.vertices[i].first_dof] = static_cast<int>(i);

  const std::vector<std::int64_t> global = space.global_nodes();
  const std::vector<std::int32_t> facets = owned_facets(space.mesh(), group, key);
  const std::vector<std::vector<std::int32_t>> nodes = nodes_of(space, facets);
  const std::vector<std::array<double, 3>> normals = normals_of(space, facets);
  std::vector<SurfaceMesh::Facet> mine;
  for (std::size_t i = 0; i < facets.size(); ++i) {
    SurfaceMesh::Facet facet{.vertices = {-1, -1, -1}, .normal = normals[i]};
    bool on_axis = true;
    for (std::size_t corner = 0; corner < static_cast<std::size_t>(dim); ++corner) { // vertices come first
      const auto found =
          number.find(static_cast<PetscInt>(global[static_cast<std::size_t>(nodes[i][corner])] * dim));
      if (found == number.end())
        continue; // of a facet on the axis alone
      facet.vertices[corner] = found->second;
      on_axis =
          on_axis && space.on_axis_of_revolution(made.vertices[static_cast<std::size_t>(found->second)].x[0]);
    }
    if (!on_axis)
      mine.push_back(facet);
  }
  made.facets = gather(space.comm(), mine);
  for (SurfaceMesh::Facet& facet : made.facets)
    std::ranges::sort(facet.vertices, std::greater()); // −1 is last in the plane
  std::ranges::sort(made.facets, {}, &SurfaceMesh::Facet::vertices);
  if (space.degree() > 1)
    add_midpoints(dim, edges, number, made);
  return made;
}

} // namespace signorini::fem
