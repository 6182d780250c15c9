#include "base/linear_solver.h"
#include "base/error.h"
#include <fmt/format.h>

namespace signorini {
using petsc::check;

Factorisation::Factorisation(Mat matrix) {
  int size = 1;
  MPI_Comm_size(petsc::comm(matrix), &size);
  const MatSolverType package = size == 1 ? MATSOLVERCHOLMOD : MATSOLVERMUMPS;
  PC pc = nullptr;
  check(KSPCreate(petsc::comm(matrix), ksp_.put()));
  check(KSPSetOperators(ksp_, matrix, matrix));
  check(KSPSetType(ksp_, KSPPREONLY));
  constexpr double tolerance = 1e-12; // of an iterative solver that options may put in its place
  check(KSPSetTolerances(ksp_, tolerance, 0, PETSC_CURRENT, PETSC_CURRENT));
  check(KSPGetPC(ksp_, &pc));
  check(PCSetType(pc, PCCHOLESKY));
  check(PCFactorSetMatSolverType(pc, package));
  check(KSPSetOptionsPrefix(ksp_, "step_"));
  check(KSPSetFromOptions(ksp_));
  check(KSPSetUp(ksp_));
  PCFailedReason failed = PC_NOERROR;
  check(PCGetFailedReason(pc, &failed));
  if (failed != PC_NOERROR)
    throw SolverFailure(fmt::format("the factorisation of the step operator D failed: {}",
                                    PCFailedReasons[failed]));
  MatSolverType used = nullptr;
  PetscBool direct = PETSC_FALSE;
  check(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(pc), &direct, PCCHOLESKY, PCLU, ""));
  if (direct)
    check(PCFactorGetMatSolverType(pc, &used));
  package_ = used ? used : "options";
}

void Factorisation::solve(Vec b, Vec x) const {
  check(KSPSolve(ksp_, b, x));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(ksp_, &reason));
  if (reason < 0)
    throw SolverFailure(fmt::format("the solve with the step operator D failed: {}",
                                    KSPConvergedReasons[reason]));
}

} // namespace signorini
