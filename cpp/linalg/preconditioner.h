// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/petsc.h"
#include <string>

namespace signorini {

/// Preconditioner of conjugate gradients for one symmetric positive definite matrix, set up once. PETSc
/// options with the prefix `-step_pc_` are honoured.
class Preconditioner {
public:
  enum class Kind {
    block_jacobi, ///< one block per node: does not depend on the number of ranks
    multigrid     ///< smoothed aggregation (PETSc's GAMG) by the matrix's near null space, the rigid motions
  };

  /// `matrix`, in blocks, must outlive this object unchanged. Collective. Throws SolverFailure.
  Preconditioner(Mat matrix, Kind kind);

  /// Whether the options name a type, whatever the kind.
  [[nodiscard]] static bool given_by_options();

  /// y = the preconditioner's x. Collective.
  [[nodiscard]] PetscErrorCode apply(Vec x, Vec y) const { return PCApply(preconditioner_, x, y); }

  [[nodiscard]] std::string name() const;

  /// Memory on all ranks as far as PETSc tells it, bytes. Collective.
  [[nodiscard]] double bytes() const;

private:
  petsc::Matrix rows_; ///< copy of the matrix in the format that other types than block Jacobi need
  petsc::Preconditioner preconditioner_;
};

} // namespace signorini
