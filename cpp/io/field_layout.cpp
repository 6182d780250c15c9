// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/field_layout.h"
#include "base/collective.h"
#include "base/dolfinx_versions.h"
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/la/Vector.h>
#include <dolfinx/mesh/Mesh.h>
#include <functional>
#include <numeric>

namespace signorini::io {
namespace {

constexpr std::size_t padded = 3; // readers of XDMF expect vectors in space

/// Calls `visit(node, geometry)` for the vertices of cells: their local nodes in V and in the mesh's
/// geometry.
template <class Visit>
void for_vertices(const fem::Space& space, std::int32_t cell, Visit&& visit) {
  const auto mesh = space.mesh().dolfinx();
  const auto geometry = dolfinx_versions::cell_nodes(mesh->geometry());
  const auto nodes = space.dolfinx()->dofmap()->cell_dofs(cell);
  for (std::size_t i = 0; i < geometry.extent(1); ++i) // the nodes at vertices are the first, of degree 2 too
    visit(static_cast<std::size_t>(nodes[i]),
          static_cast<std::size_t>(geometry(static_cast<std::size_t>(cell), i)));
}

std::int32_t local_cells(const fem::Space& space) {
  const auto map = space.mesh().dolfinx()->topology()->index_map(space.dim());
  return map->size_local() + map->num_ghosts();
}

/// The owned nodes of V that are vertices, ascending.
std::vector<std::size_t> vertices(const fem::Space& space) {
  std::vector<bool> vertex(static_cast<std::size_t>(space.owned_nodes()));
  for (std::int32_t cell = 0; cell < local_cells(space); ++cell)
    for_vertices(space, cell, [&](std::size_t node, std::size_t) {
      if (node < vertex.size())
        vertex[node] = true;
    });
  std::vector<std::size_t> found;
  for (std::size_t node = 0; node < vertex.size(); ++node)
    if (vertex[node])
      found.push_back(node);
  return found;
}

/// The places of the owned cells' values in a function that is constant on each cell.
std::vector<std::size_t> places(const fem::Space& space) {
  const auto constants = fem::cellwise(space.mesh(), {});
  std::vector<std::size_t> found;
  for (const std::int32_t cell : space.mesh().owned_cells())
    found.push_back(static_cast<std::size_t>(constants->dofmap()->cell_dofs(cell)[0]));
  return found;
}

std::size_t components(Values values, int dim) {
  return values == Values::nodal || values == Values::cellwise ? static_cast<std::size_t>(dim)
                                                               : stored_components(values);
}

} // namespace

bool in_cells(Values values) { return values != Values::nodal && values != Values::nodal_scalar; }

std::vector<std::size_t> stored_shape(Values values) {
  switch (values) {
  case Values::nodal:
  case Values::cellwise:
    return {padded};
  case Values::cellwise_tensor:
    return {padded, padded};
  default:
    return {1};
  }
}

std::size_t stored_components(Values values) {
  const std::vector<std::size_t> shape = stored_shape(values);
  return std::accumulate(shape.begin(), shape.end(), std::size_t(1), std::multiplies<>());
}

FieldLayout::FieldLayout(const fem::Space& space)
    : space_(space), nodes_(rows_of(vertices(space))), cells_(rows_of(places(space))) {}

FieldLayout::Rows FieldLayout::rows_of(std::vector<std::size_t> own) const {
  Rows rows{.own = std::move(own), .counts = {}, .starts = {}};
  rows.counts = signorini::gather(space_.comm(), std::vector<int>{static_cast<int>(rows.own.size())});
  rows.starts.assign(rows.counts.size(), 0);
  std::partial_sum(rows.counts.begin(), rows.counts.end() - 1, rows.starts.begin() + 1);
  return rows;
}

template <class T>
void FieldLayout::gather(const Rows& rows, std::size_t columns, const std::vector<T>& mine,
                         std::vector<T>& all) const {
  all.resize(rank(space_.comm()) == 0 ? rows.total() * columns : 0);
  MPI_Datatype row = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(static_cast<int>(columns * sizeof(T)), MPI_BYTE, &row);
  MPI_Type_commit(&row);
  MPI_Gatherv(mine.data(), static_cast<int>(rows.own.size()), row, all.data(), rows.counts.data(),
              rows.starts.data(), row, 0, space_.comm());
  MPI_Type_free(&row);
}

std::vector<double> FieldLayout::points() const {
  const auto dim = static_cast<std::size_t>(space_.dim());
  const std::span<const double> x = space_.mesh().dolfinx()->geometry().x();
  std::vector<double> at(static_cast<std::size_t>(space_.owned_nodes()) * dim), mine, all;
  for (std::int32_t cell = 0; cell < local_cells(space_); ++cell)
    for_vertices(space_, cell, [&](std::size_t node, std::size_t geometry) {
      if (dim * node < at.size())
        std::copy_n(&x[3 * geometry], dim, &at[dim * node]);
    });
  for (const std::size_t node : nodes_.own)
    mine.insert(mine.end(), &at[dim * node], &at[dim * node] + dim);
  gather(nodes_, dim, mine, all);
  return all;
}

std::vector<std::int64_t> FieldLayout::topology() const {
  dolfinx::la::Vector<std::int64_t> numbers(space_.dolfinx()->dofmap()->index_map, 1);
  std::int64_t next = nodes_.starts[static_cast<std::size_t>(rank(space_.comm()))];
  for (const std::size_t node : nodes_.own)
    dolfinx_versions::entries(numbers)[node] = next++;
  numbers.scatter_fwd();
  std::vector<std::int64_t> mine, all;
  for (const std::int32_t cell : space_.mesh().owned_cells())
    for_vertices(space_, cell, [&](std::size_t node, std::size_t) { mine.push_back(numbers.array()[node]); });
  gather(cells_, static_cast<std::size_t>(space_.dim()) + 1, mine, all);
  return all;
}

std::span<const double> FieldLayout::gather(Values values, std::span<const double> owned) {
  const Rows& rows = in_cells(values) ? cells_ : nodes_;
  const std::size_t given = components(values, space_.dim()), stored = stored_components(values);
  mine_.assign(rows.own.size() * stored, 0);
  for (std::size_t i = 0; i < rows.own.size(); ++i)
    std::copy_n(&owned[given * rows.own[i]], given, &mine_[stored * i]);
  if (ranks(space_.comm()) == 1)
    return mine_;
  gather(rows, stored, mine_, all_);
  return all_;
}

} // namespace signorini::io
