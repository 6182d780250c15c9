// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/layout.h"
#include "base/collective.h"
#include <utility>

namespace signorini::fem {
using petsc::check;

Layout::Layout(MPI_Comm comm, int dim, int mesh_nodes, std::vector<VirtualNode> virtual_nodes)
    : comm_(comm), dim_(dim), mesh_nodes_(mesh_nodes), virtual_(std::move(virtual_nodes)),
      here_(rank(comm) + 1 == ranks(comm)) {
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

} // namespace signorini::fem
