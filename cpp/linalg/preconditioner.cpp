// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/preconditioner.h"
#include "base/error.h"
#include <fmt/format.h>
#include <string_view>

namespace signorini {
using petsc::check;

namespace {

constexpr const char* prefix = "step_";

/// A copy by rows, with the near null space. Collective.
petsc::Matrix by_rows(Mat matrix) {
  petsc::Matrix rows;
  check(MatConvert(matrix, MATAIJ, MAT_INITIAL_MATRIX, rows.put()));
  check(MatSetOption(rows, MAT_SPD, PETSC_TRUE));
  MatNullSpace motions = nullptr;
  check(MatGetNearNullSpace(matrix, &motions));
  check(MatSetNearNullSpace(rows, motions));
  return rows;
}

} // namespace

bool Preconditioner::given_by_options() {
  PetscBool given = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, prefix, "-pc_type", &given));
  return given != PETSC_FALSE;
}

Preconditioner::Preconditioner(Mat matrix, Kind kind) {
  check(PCCreate(petsc::comm(matrix), preconditioner_.put()));
  check(PCSetOptionsPrefix(preconditioner_, prefix));
  check(PCSetOperators(preconditioner_, matrix, matrix));
  check(PCSetType(preconditioner_, kind == Kind::multigrid ? PCGAMG : PCPBJACOBI));
  check(PCSetFromOptions(preconditioner_));
  if (name() != PCPBJACOBI) {
    rows_ = by_rows(matrix);
    check(PCSetOperators(preconditioner_, rows_, rows_));
  }
  check(PCSetUp(preconditioner_));
  check(PCSetUpOnBlocks(preconditioner_));
  PCFailedReason failed = PC_NOERROR;
  check(PCGetFailedReason(preconditioner_, &failed));
  if (failed != PC_NOERROR)
    throw SolverFailure(fmt::format("the preconditioner of the step operator D could not be set up: {}",
                                    PCFailedReasons[failed]));
}

std::string Preconditioner::name() const {
  PCType type = nullptr;
  check(PCGetType(preconditioner_, &type));
  return type;
}

double Preconditioner::bytes() const {
  Mat matrix = nullptr;
  PetscInt rows = 0, block = 1;
  check(PCGetOperators(preconditioner_, &matrix, nullptr));
  check(MatGetSize(matrix, &rows, nullptr));
  check(MatGetBlockSize(matrix, &block));
  if (!rows_) // one block per node
    return sizeof(PetscScalar) * static_cast<double>(rows) * static_cast<double>(block);
  double bytes = petsc::bytes(rows_);
  if (name() == PCGAMG) {
    PetscReal grid = 1, of_finest = 1;
    check(PCMGGetGridComplexity(preconditioner_, &grid, &of_finest));
    bytes *= of_finest; // entries on all levels over those on the finest
  }
  return bytes;
}

} // namespace signorini
