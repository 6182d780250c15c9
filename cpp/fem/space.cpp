// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/space.h"
#include "base/collective.h"
#include "base/dolfinx_versions.h"
#include <basix/cell.h>
#include <basix/finite-element.h>
#include <cmath>
#include <dolfinx/fem/DirichletBC.h>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/fem/utils.h>
#include <dolfinx/mesh/Mesh.h>
#include <dolfinx/mesh/utils.h>
#include <numeric>

namespace signorini::fem {

namespace {

/// A space of functions of `degree`. Collective.
std::shared_ptr<dolfinx::fem::FunctionSpace<double>> functions(const mesh::Mesh& mesh, int degree,
                                                               bool discontinuous, const Shape& shape) {
  const auto cell = dolfinx::mesh::cell_type_to_basix_type(mesh.dolfinx()->topology()->cell_type());
  // The variant must be that of basix.ufl.element in forms/: dolfinx compares the elements' hashes.
  const auto element = basix::create_element<double>(basix::element::family::P, cell, degree,
                                                     basix::element::lagrange_variant::gll_warped,
                                                     basix::element::dpc_variant::unset, discontinuous);
  return std::make_shared<dolfinx::fem::FunctionSpace<double>>(
      dolfinx_versions::create_functionspace(mesh.dolfinx(), element, shape));
}

Shape vector(const mesh::Mesh& mesh) { return {static_cast<std::size_t>(mesh.dim())}; }

} // namespace

std::shared_ptr<dolfinx::fem::FunctionSpace<double>> lagrange(const mesh::Mesh& mesh, int degree,
                                                              const Shape& shape) {
  return functions(mesh, degree, false, shape);
}

std::shared_ptr<dolfinx::fem::FunctionSpace<double>> lagrange(const mesh::Mesh& mesh, int degree) {
  return lagrange(mesh, degree, vector(mesh));
}

std::shared_ptr<dolfinx::fem::FunctionSpace<double>> cellwise(const mesh::Mesh& mesh, const Shape& shape) {
  return functions(mesh, 0, true, shape);
}

std::shared_ptr<dolfinx::fem::FunctionSpace<double>> cellwise(const mesh::Mesh& mesh) {
  return cellwise(mesh, vector(mesh));
}

Space::Space(const mesh::Mesh& mesh, int degree, std::vector<VirtualNode> virtual_nodes)
    : mesh_(&mesh), degree_(degree), V_(lagrange(mesh, degree)),
      layout_(mesh.comm(), mesh.dim(), V_->dofmap()->index_map->size_local(), std::move(virtual_nodes)) {
  points_ = V_->tabulate_dof_coordinates(false);
  points_.resize(3 * static_cast<std::size_t>(owned_nodes()));
  // Rounding moves nodes off the coordinate planes, where an expression may have a pole or a jump.
  for (double& coordinate : points_)
    if (std::abs(coordinate) < 1e-14 * mesh.diameter())
      coordinate = 0;
}

std::vector<int> Space::nodes_on(const std::string& group, const std::string& key) const {
  const auto topology = mesh_->dolfinx()->topology();
  std::vector<std::int32_t> nodes = dolfinx::fem::locate_dofs_topological(
      *topology, *V_->dofmap(), topology->dim() - 1, mesh_->facets(group, key), true);
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

std::vector<double> Space::midpoints() const {
  return dolfinx::mesh::compute_midpoints(*mesh_->dolfinx(), dim(), mesh_->owned_cells());
}

using petsc::check;

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
