// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/degree_raising.h"
#include <basix/cell.h>
#include <dolfinx/fem/FunctionSpace.h>

namespace signorini::fem {
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
