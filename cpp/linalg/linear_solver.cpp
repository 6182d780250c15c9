#include "linalg/linear_solver.h"
#include "base/counters.h"
#include "base/error.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

namespace signorini {
using petsc::check;

namespace {
long& solves = count("solves with D");
constexpr const char* prefix = "step_";
constexpr double megabyte = 1e6; // the unit of INFOG(17) and INFOG(22)
/// Relative residuals at which the judge is called: early, where most changes already show, and once more.
constexpr std::array judged_at{1e-3, 1e-6};
} // namespace

void LinearSolver::count_solves(long made) { solves += made; }

MumpsSolver::MumpsSolver(Mat matrix) {
  check(MatConvert(matrix, MATAIJ, MAT_INITIAL_MATRIX, matrix_.put()));
  check(MatSetOption(matrix_, MAT_SPD, PETSC_TRUE));
  check(MatSetOptionsPrefixFactor(matrix_, prefix));
  analyse();
}

void MumpsSolver::analyse() {
  check(MatGetFactor(matrix_, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, factor_.put()));
  MatFactorInfo info;
  check(MatFactorInfoInitialize(&info));
  check(MatCholeskyFactorSymbolic(factor_, matrix_, nullptr, &info));
}

double MumpsSolver::estimate() const {
  PetscInt megabytes = 0;
  check(MatMumpsGetInfog(factor_, 17, &megabytes));
  return megabyte * static_cast<double>(megabytes);
}

void MumpsSolver::factorise() {
  // Which rank takes which part is decided by their loads at the time, so that the space estimated by the
  // analysis may fall short, at random. Space that is not used costs no memory: twice as much is set aside,
  // and where even that is too little, or the user's own option, more.
  constexpr PetscInt twice = 100, most = 1000; // per cent
  PetscBool chosen = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, prefix, "-mat_mumps_icntl_14", &chosen));
  if (!chosen)
    check(MatMumpsSetIcntl(factor_, 14, twice));
  PetscInt extra = 0;
  check(MatMumpsGetIcntl(factor_, 14, &extra));
  MatFactorInfo info;
  check(MatFactorInfoInitialize(&info));
  check(MatCholeskyFactorNumeric(factor_, matrix_, &info));
  while (short_of_space() && extra < most) {
    extra = std::max<PetscInt>(2 * extra, twice);
    analyse();
    check(MatMumpsSetIcntl(factor_, 14, extra));
    check(MatCholeskyFactorNumeric(factor_, matrix_, &info));
  }
  PetscInt error = 0, detail = 0;
  check(MatMumpsGetInfog(factor_, 1, &error));
  check(MatMumpsGetInfog(factor_, 2, &detail));
  if (error < 0)
    throw SolverFailure(
        fmt::format("the factorisation of the step operator D by MUMPS failed: INFOG(1) = {}, "
                    "INFOG(2) = {}",
                    error, detail));
  matrix_ = {};
}

bool MumpsSolver::short_of_space() const {
  PetscInt error = 0;
  check(MatMumpsGetInfog(factor_, 1, &error));
  // Workspace (-8, -9) or message buffers (-17, -20) too small: MUMPS users' guide, INFOG(1).
  return error == -8 || error == -9 || error == -17 || error == -20;
}

void MumpsSolver::solve(Vec b, Vec x) const {
  check(MatSolve(factor_, b, x));
  count_solves();
}

petsc::Matrix MumpsSolver::solve_sparse(Mat transposed) const {
  PetscInt columns = 0, rows = 0;
  check(MatGetSize(transposed, &columns, nullptr));
  check(MatGetLocalSize(factor_, &rows, nullptr));
  petsc::Matrix X;
  check(MatCreateDense(petsc::comm(transposed), rows, PETSC_DECIDE, PETSC_DETERMINE, columns, nullptr,
                       X.put()));
  check(MatMatTransposeSolve(factor_, transposed, X));
  count_solves(columns);
  return X;
}

double MumpsSolver::bytes() const {
  PetscInt megabytes = 0;
  check(MatMumpsGetInfog(factor_, 22, &megabytes));
  return megabyte * static_cast<double>(megabytes);
}

ConjugateGradients::ConjugateGradients(Mat matrix) {
  check(KSPCreate(petsc::comm(matrix), ksp_.put()));
  check(KSPSetOperators(ksp_, matrix, matrix));
  check(KSPSetType(ksp_, KSPCG));
  check(KSPSetNormType(ksp_, KSP_NORM_NATURAL));
  check(KSPSetInitialGuessNonzero(ksp_, PETSC_TRUE));
  constexpr double tolerance = 1e-12; // the gradient of J is accurate to about this
  constexpr PetscInt most = 2000;
  check(KSPSetTolerances(ksp_, tolerance, 0, PETSC_CURRENT, most));
  check(KSPSetOptionsPrefix(ksp_, prefix));
  PC shell = nullptr;
  check(KSPGetPC(ksp_, &shell));
  check(PCSetType(shell, PCSHELL));
  check(PCSetOptionsPrefix(shell, "step_projected_")); // -step_pc_… is the preconditioner inside
  check(PCShellSetApply(shell, precondition));
  check(KSPSetFromOptions(ksp_));
  check(KSPGetTolerances(ksp_, &tolerance_, nullptr, nullptr, nullptr));

  projected_ = petsc::vector_of(matrix);
  check(PCCreate(petsc::comm(matrix), preconditioner_.put()));
  check(PCSetOperators(preconditioner_, matrix, matrix));
  check(PCSetType(preconditioner_, PCPBJACOBI));
  check(PCSetOptionsPrefix(preconditioner_, prefix));
  check(PCSetFromOptions(preconditioner_));
  check(PCSetUp(preconditioner_));
  check(PCSetUpOnBlocks(preconditioner_));
  PCFailedReason failed = PC_NOERROR;
  check(PCGetFailedReason(preconditioner_, &failed));
  if (failed != PC_NOERROR)
    throw SolverFailure(fmt::format("the preconditioner of the step operator D could not be set up: {}",
                                    PCFailedReasons[failed]));
  PCType type = nullptr;
  check(PCGetType(preconditioner_, &type));
  name_ = fmt::format("CG with {}", type);
}

PetscErrorCode ConjugateGradients::precondition(PC shell, Vec x, Vec y) {
  PetscFunctionBeginUser;
  void* context = nullptr;
  PetscCall(PCShellGetContext(shell, &context));
  const Solve& now = *static_cast<const Solve*>(context);
  const ConjugateGradients& self = now.solver;
  if (!now.project) {
    PetscCall(PCApply(self.preconditioner_, x, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  try {
    PetscCall(VecCopy(x, self.projected_));
    (*now.project)(self.projected_);
    PetscCall(PCApply(self.preconditioner_, self.projected_, y));
    (*now.project)(y);
  } catch (...) { // no exception may propagate through PETSc's C code
    PetscFunctionReturn(PETSC_ERR_LIB);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ConjugateGradients::converged(KSP ksp, PetscInt iteration, PetscReal residual,
                                             KSPConvergedReason* reason, void* context) {
  PetscFunctionBeginUser;
  Solve& now = *static_cast<Solve*>(context);
  *reason = KSP_CONVERGED_ITERATING;
  if (iteration == 0) // for a zero guess the residual measures the solution
    now.scale = std::max(now.scale, residual);
  const auto due = std::ranges::count_if(judged_at, [&](double at) { return residual <= at * now.scale; });
  if (!std::isfinite(residual)) {
    *reason = KSP_DIVERGED_NANORINF;
  } else if (residual <= now.solver.tolerance_ * now.scale) {
    *reason = KSP_CONVERGED_RTOL;
  } else if (now.judge && due > now.asked) {
    now.asked = due;
    Vec x = nullptr;
    PetscCall(KSPBuildSolution(ksp, nullptr, &x));
    try {
      now.stopped = !(*now.judge)(x);
    } catch (...) {
      PetscFunctionReturn(PETSC_ERR_LIB);
    }
    if (now.stopped)
      *reason = KSP_CONVERGED_RTOL;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void ConjugateGradients::solve(Vec b, Vec x) const {
  Solve solve{.solver = *this};
  run(b, x, solve);
}

bool ConjugateGradients::solve(Vec b, Vec x, const Projector& project, const Judge& judge) const {
  Solve solve{.solver = *this, .project = &project, .judge = judge ? &judge : nullptr};
  run(b, x, solve);
  return !solve.stopped;
}

void ConjugateGradients::run(Vec b, Vec x, Solve& solve) const {
  PC shell = nullptr;
  check(KSPGetPC(ksp_, &shell));
  check(PCShellSetContext(shell, &solve));
  check(KSPSetConvergenceTest(ksp_, converged, &solve, nullptr));
  solve.scale = std::sqrt(std::abs(petsc::dot(b, x))); // energy norm of the guess: x·b ≈ x·Dx
  check(KSPSolve(ksp_, b, x));
  count_solves();
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(ksp_, &reason));
  if (reason >= 0)
    return;
  PetscInt iterations = 0;
  PetscReal residual = 0;
  check(KSPGetIterationNumber(ksp_, &iterations));
  check(KSPGetResidualNorm(ksp_, &residual));
  throw SolverFailure(
      fmt::format("the solve with the step operator D by {} failed: {}, residual {:.3e} of {:.3e} after {} "
                  "iterations",
                  name_, KSPConvergedReasons[reason], residual, solve.scale, static_cast<int>(iterations)));
}

double ConjugateGradients::bytes() const {
  // Block Jacobi stores one block per node; PETSc does not report the memory of preconditioners that options
  // may choose instead.
  Mat matrix = nullptr;
  PetscInt rows = 0, block = 1;
  check(KSPGetOperators(ksp_, &matrix, nullptr));
  check(MatGetSize(matrix, &rows, nullptr));
  check(MatGetBlockSize(matrix, &block));
  return sizeof(PetscScalar) * static_cast<double>(rows) * static_cast<double>(block);
}

} // namespace signorini
