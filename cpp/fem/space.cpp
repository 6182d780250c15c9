// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/space.h"
#include "base/collective.h"
#include "base/dolfinx_versions.h"
#include "fem/node_order.h"
#include <basix/cell.h>
#include <basix/finite-element.h>
#include <cmath>
#include <dolfinx/fem/DirichletBC.h>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/Mesh.h>
#include <dolfinx/mesh/utils.h>
#include <numeric>
#include <utility>

namespace signorini::fem {
using petsc::check;

Layout::Layout(MPI_Comm comm, int dim, int mesh_nodes, std::vector<VirtualNode> virtual_nodes)
    : comm_(comm), dim_(dim), mesh_nodes_(mesh_nodes), virtual_(std::move(virtual_nodes)),
      owns_virtual_nodes_(rank(comm) + 1 == ranks(comm)) {
  const PetscInt own = static_cast<PetscInt>(nodes()) * dim;
  PetscInt end = 0;
  MPI_Scan(&own, &end, 1, MPIU_INT, MPI_SUM, comm);
  MPI_Allreduce(&own, &dofs_, 1, MPIU_INT, MPI_SUM, comm);
  first_dof_ = end - own;
}

petsc::Vector Layout::vector() const {
  petsc::Vector x;
  check(VecCreate(comm_, x.put()));
  check(VecSetSizes(x, nodes() * dim_, dofs_));
  check(VecSetBlockSize(x, dim_));
  check(VecSetType(x, VECSTANDARD));
  check(VecZeroEntries(x));
  return x;
}

petsc::Matrix Layout::extended(petsc::Matrix matrix, std::span<const double> diagonal) const {
  if (virtual_.empty())
    return matrix;
  MatType type = nullptr;
  PetscInt rows = 0, columns = 0, all_rows = 0, all_columns = 0, row_block = 1, column_block = 1;
  check(MatGetType(matrix, &type));
  check(MatGetLocalSize(matrix, &rows, &columns));
  check(MatGetSize(matrix, &all_rows, &all_columns));
  check(MatGetBlockSizes(matrix, &row_block, &column_block));
  const PetscInt more = static_cast<PetscInt>(nodes()) * dim_ - rows;
  const bool square = all_rows == all_columns;
  petsc::Matrix made;
  check(MatCreate(comm_, made.put()));
  check(MatSetSizes(made, rows + more, columns + (square ? more : 0), PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(made, type));
  check(MatSetBlockSizes(made, row_block, column_block));
  check(MatSetUp(made)); // PETSc counts the entries as they come
  PetscInt first = 0, end = 0;
  check(MatGetOwnershipRange(matrix, &first, &end));
  for (PetscInt row = first; row < end; ++row) { // the mesh's dofs keep their numbers
    PetscInt n = 0;
    const PetscInt* at = nullptr;
    const PetscScalar* values = nullptr;
    check(MatGetRow(matrix, row, &n, &at, &values));
    check(MatSetValues(made, 1, &row, n, at, values, INSERT_VALUES));
    check(MatRestoreRow(matrix, row, &n, &at, &values));
  }
  for (PetscInt i = 0; square && i < more; ++i)
    check(MatSetValue(made, end + i, end + i, diagonal.empty() ? 0 : diagonal[static_cast<std::size_t>(i)],
                      INSERT_VALUES));
  check(MatAssemblyBegin(made, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(made, MAT_FINAL_ASSEMBLY));
  return made;
}

petsc::Matrix Layout::diagonal(std::span<const double> diagonal) const {
  const petsc::Vector entries = vector();
  if (owns_virtual_nodes_) {
    const petsc::WriteArray values(entries);
    std::ranges::copy(diagonal, std::span<PetscScalar>(values).subspan(mesh_dofs()).begin());
  }
  petsc::Matrix made;
  check(MatCreateDiagonal(entries, made.put()));
  return made;
}

namespace {

/// Creates the space of Lagrange functions of `degree`. `order`: numbers the nodes of each rank; null for the
/// order of dolfinx. Collective.
std::shared_ptr<dolfinx::fem::FunctionSpace<double>>
functions(const mesh::Mesh& mesh, int degree, bool discontinuous, const Shape& shape,
          const dolfinx_versions::NodeOrder& order = nullptr) {
  const auto cell = dolfinx::mesh::cell_type_to_basix_type(mesh.dolfinx()->topology()->cell_type());
  // The variant must be that of basix.ufl.element in forms/: dolfinx compares the elements' hashes.
  const auto element = basix::create_element<double>(basix::element::family::P, cell, degree,
                                                     basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, discontinuous);
  return std::make_shared<dolfinx::fem::FunctionSpace<double>>(
      dolfinx_versions::create_functionspace(mesh.dolfinx(), element, shape, order));
}

/// Returns the order of the nodes of V. In space it halves the bandwidth of D, and products take 6 to 10 %
/// less time; in the plane factors solve the steps, and their order is their own.
dolfinx_versions::NodeOrder node_order(const mesh::Mesh& mesh) {
  return mesh.dim() == 3 ? dolfinx_versions::NodeOrder(breadth_first_order) : nullptr;
}

Shape vector_shape(const mesh::Mesh& mesh) { return {static_cast<std::size_t>(mesh.dim())}; }

} // namespace

std::shared_ptr<dolfinx::fem::FunctionSpace<double>> cellwise(const mesh::Mesh& mesh, const Shape& shape) {
  return functions(mesh, 0, true, shape);
}

std::shared_ptr<dolfinx::fem::FunctionSpace<double>> cellwise(const mesh::Mesh& mesh) {
  return cellwise(mesh, vector_shape(mesh));
}

Space::Space(const mesh::Mesh& mesh, int degree, std::vector<VirtualNode> virtual_nodes)
    : mesh_(&mesh), degree_(degree), V_(functions(mesh, degree, false, vector_shape(mesh), node_order(mesh))),
      layout_(mesh.comm(), mesh.dim(), V_->dofmap()->index_map->size_local(), std::move(virtual_nodes)) {
  points_ = V_->tabulate_dof_coordinates(false);
  points_.resize(3 * static_cast<std::size_t>(owned_nodes()));
  // Rounding moves nodes off the coordinate planes, where an expression may have a pole or a jump.
  for (double& coordinate : points_)
    if (std::abs(coordinate) < 1e-14 * mesh.diameter())
      coordinate = 0;
}

Space::Space(const Space& space, std::vector<VirtualNode> virtual_nodes)
    : mesh_(space.mesh_), degree_(space.degree_), V_(space.V_),
      layout_(space.comm(), space.dim(), space.owned_nodes(), std::move(virtual_nodes)),
      points_(space.points_) {}

std::vector<int> Space::nodes_on(const std::string& group, const std::string& key, bool with_area) const {
  const auto topology = mesh_->dolfinx()->topology();
  std::vector<std::int32_t> facets = mesh_->facets(group, key);
  if (with_area && mesh_->axisymmetric()) {
    const std::vector<double> x =
        dolfinx::mesh::compute_midpoints(*mesh_->dolfinx(), topology->dim() - 1, std::span(facets));
    std::size_t i = 0;
    std::erase_if(facets, [&](std::int32_t) { return x[3 * i++] == 0; });
  }
  std::vector<std::int32_t> nodes =
      dolfinx::fem::locate_dofs_topological(*topology, *V_->dofmap(), topology->dim() - 1, facets, true);
  std::erase_if(nodes, [&](std::int32_t node) { return node >= owned_nodes(); });
  return {nodes.begin(), nodes.end()};
}

void Space::interpolate(const scene::Field& field, double t, Vec out) const {
  const petsc::WriteArray values(out);
  const auto dim = static_cast<std::size_t>(mesh_->dim());
  on_all_ranks(comm(), [&] {
    for (std::size_t i = 0; 3 * i < points_.size(); ++i)
      field.evaluate(&points_[3 * i], t, &values[dim * i]);
  });
}

std::vector<std::int64_t> Space::global_nodes() const {
  const auto map = V_->dofmap()->index_map;
  std::vector<std::int32_t> local(static_cast<std::size_t>(map->size_local() + map->num_ghosts()));
  std::iota(local.begin(), local.end(), 0);
  std::vector<std::int64_t> global(local.size());
  map->local_to_global(local, global);
  return global;
}

std::vector<double> Space::midpoints() const {
  return dolfinx::mesh::compute_midpoints(*mesh_->dolfinx(), dim(), mesh_->owned_cells());
}

petsc::Matrix embedding(const Space& linear, const Space& quadratic) {
  petsc::Matrix one;
  check(MatCreate(linear.comm(), one.put()));
  check(MatSetSizes(one, quadratic.owned_nodes(), linear.owned_nodes(), PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(one, MATAIJ));
  check(MatSetUp(one));
  const auto dofs_of = [](const Space& space, std::int32_t cell) {
    const auto dofmap = space.dolfinx()->dofmap();
    const auto local = dofmap->cell_dofs(cell);
    std::vector<std::int64_t> global(local.size());
    dofmap->index_map->local_to_global(local, global);
    return std::vector<PetscInt>(global.begin(), global.end());
  };
  const auto set = [&one](PetscInt row, PetscInt column, double value) {
    check(MatSetValue(one, row, column, value, INSERT_VALUES));
  };
  const auto cell_type = linear.dim() == 2 ? basix::cell::type::triangle : basix::cell::type::tetrahedron;
  const std::vector<std::vector<int>> edges = basix::cell::topology(cell_type)[1];
  for (std::int32_t cell : linear.mesh().owned_cells()) {
    const std::vector<PetscInt> from = dofs_of(linear, cell), to = dofs_of(quadratic, cell);
    for (std::size_t i = 0; i < from.size(); ++i)
      set(to[i], from[i], 1);
    for (std::size_t e = 0; e < edges.size(); ++e)
      for (int end : edges[e])
        set(to[from.size() + e], from[static_cast<std::size_t>(end)], 0.5);
  }
  check(MatAssemblyBegin(one, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(one, MAT_FINAL_ASSEMBLY));
  petsc::Matrix all;
  check(MatCreateMAIJ(one, linear.dim(), all.put()));
  return all;
}

} // namespace signorini::fem
