// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/linear_solver.h"
#include "base/error.h"
#include "base/timers.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <memory>

namespace signorini {
using petsc::check;

namespace {
long& solves = count("solves with D");
long& iterations_made = count("iterations of conjugate gradients");
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

FactorWork MumpsSolver::work() const {
  constexpr double million =
      1e6; // in which MUMPS counts what an integer has no room for, as a negative number
  FactorWork work;
  PetscInt entries = 0;
  check(MatMumpsGetRinfog(factor_, 1, &work.flops));
  check(MatMumpsGetInfog(factor_, 20, &entries));
  work.entries = entries < 0 ? -million * static_cast<double>(entries) : static_cast<double>(entries);
  return work;
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

ConjugateGradients::ConjugateGradients(Mat matrix, double solves, double most)
    : matrix_(matrix), right_hand_side_(petsc::vector_of(matrix)), projected_(petsc::vector_of(matrix)) {
  PetscInt owned = 0;
  check(MatGetLocalSize(matrix, &owned, nullptr));
  check(MatCreateShell(petsc::comm(matrix), owned, owned, PETSC_DETERMINE, PETSC_DETERMINE, this,
                       operator_.put()));
  // The operation's type has no arguments.
  check(MatShellSetOperation(operator_, MATOP_MULT, reinterpret_cast<void (*)()>(multiply)));
  check(KSPCreate(petsc::comm(matrix), ksp_.put()));
  check(KSPSetOperators(ksp_, operator_, matrix));
  check(KSPSetType(ksp_, KSPCG));
  check(KSPSetNormType(ksp_, KSP_NORM_NATURAL));
  check(KSPSetInitialGuessNonzero(ksp_, PETSC_TRUE));
  constexpr double tolerance = 1e-12; // the gradient of J is accurate to about this
  constexpr PetscInt iterations = 2000;
  check(KSPSetTolerances(ksp_, tolerance, 0, PETSC_CURRENT, iterations));
  check(KSPSetOptionsPrefix(ksp_, prefix));
  PC shell = nullptr;
  check(KSPGetPC(ksp_, &shell));
  check(PCSetType(shell, PCSHELL));
  check(PCSetOptionsPrefix(shell, "step_projected_")); // -step_pc_… is the preconditioner inside
  check(PCShellSetContext(shell, this));
  check(PCShellSetApply(shell, precondition));
  check(KSPSetConvergenceTest(ksp_, converged, this, nullptr));
  check(KSPSetFromOptions(ksp_));
  check(KSPGetTolerances(ksp_, &tolerance_, nullptr, nullptr, nullptr));
  choose_preconditioner(matrix, solves, most);
}

void ConjugateGradients::choose_preconditioner(Mat matrix, double solves, double most) {
  // In iterations by block Jacobi, from the long steps of `./dev bench courant`: an iteration by
  // multigrid, and its set-up.
  constexpr double cycle = 12, setup = 600;
  constexpr PetscInt few = 60; // multigrid takes five at least
  preconditioner_ = std::make_unique<Preconditioner>(matrix, Preconditioner::Kind::block_jacobi);
  trial_ = try_out(most);
  const auto before = static_cast<double>(trial_.iterations);
  if (Preconditioner::given_by_options() || before <= few || solves * before < setup)
    return;
  auto multigrid = std::make_unique<Preconditioner>(matrix, Preconditioner::Kind::multigrid);
  std::swap(preconditioner_, multigrid);
  const Trial trial = try_out(most);
  if (std::isfinite(trial.seconds) &&
      setup + solves * cycle * static_cast<double>(trial.iterations) <= solves * before)
    trial_ = trial;
  else
    std::swap(preconditioner_, multigrid);
}

ConjugateGradients::Trial ConjugateGradients::try_out(double most) const {
  const petsc::Vector x = petsc::zero_like(projected_), b = petsc::zero_like(projected_);
  check(VecSet(b, 1));
  check(KSPSetUp(ksp_));
  const Clock::time_point start = Clock::now();
  Solve solve{.trial = true};
  if (std::isfinite(most))
    solve.until = start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(most));
  run(b, x, solve);
  Trial trial{.seconds = std::chrono::duration<double>(Clock::now() - start).count()};
  MPI_Bcast(&trial.seconds, 1, MPI_DOUBLE, 0, petsc::comm(projected_));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetIterationNumber(ksp_, &trial.iterations));
  check(KSPGetConvergedReason(ksp_, &reason));
  if (reason < 0)
    trial.seconds = std::numeric_limits<double>::infinity();
  return trial;
}

PetscErrorCode ConjugateGradients::project(Vec x) const {
  try {
    if (now_->project)
      (*now_->project)(x);
  } catch (...) { // no exception may propagate through PETSc's C code
    return PETSC_ERR_LIB;
  }
  return PETSC_SUCCESS;
}

PetscErrorCode ConjugateGradients::multiply(Mat shell, Vec x, Vec y) {
  PetscFunctionBeginUser;
  void* context = nullptr;
  PetscCall(MatShellGetContext(shell, static_cast<void*>(&context)));
  const ConjugateGradients& self = *static_cast<const ConjugateGradients*>(context);
  PetscCall(MatMult(self.matrix_, x, y));
  if (!self.now_->started) { // by the guess; b·x would leave out what the forces of constraints do
    self.now_->started = true;
    PetscScalar energy = 0;
    PetscCall(VecDot(x, y, &energy));
    self.now_->scale = std::sqrt(std::abs(energy));
  }
  PetscCall(self.project(y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ConjugateGradients::precondition(PC shell, Vec x, Vec y) {
  PetscFunctionBeginUser;
  void* context = nullptr;
  PetscCall(PCShellGetContext(shell, static_cast<void*>(&context)));
  const ConjugateGradients& self = *static_cast<const ConjugateGradients*>(context);
  if (!self.now_->project) {
    PetscCall(self.preconditioner_->apply(x, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecCopy(x, self.projected_));
  PetscCall(self.project(self.projected_));
  PetscCall(self.preconditioner_->apply(self.projected_, y));
  PetscCall(self.project(y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ConjugateGradients::converged(KSP ksp, PetscInt iteration, PetscReal residual,
                                             KSPConvergedReason* reason, void* context) {
  PetscFunctionBeginUser;
  const ConjugateGradients& self = *static_cast<const ConjugateGradients*>(context);
  Solve& now = *self.now_;
  *reason = KSP_CONVERGED_ITERATING;
  if (iteration == 0) // for a zero guess the residual measures the solution
    now.scale = std::max(now.scale, residual);
  const auto due = std::ranges::count_if(judged_at, [&](double at) { return residual <= at * now.scale; });
  int late = now.until && Clock::now() > *now.until;
  if (now.until)
    MPI_Bcast(&late, 1, MPI_INT, 0, PetscObjectComm(reinterpret_cast<PetscObject>(ksp)));
  if (!std::isfinite(residual)) {
    *reason = KSP_DIVERGED_NANORINF;
  } else if (residual <= self.tolerance_ * now.scale) {
    *reason = KSP_CONVERGED_RTOL;
  } else if (late) {
    *reason = KSP_DIVERGED_ITS;
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
  Solve solve;
  run(b, x, solve);
}

bool ConjugateGradients::solve(Vec b, Vec x, const Projector& project, const TerminationTest& judge) const {
  Solve solve{.project = &project, .judge = judge ? &judge : nullptr};
  run(b, x, solve);
  return !solve.stopped;
}

void ConjugateGradients::run(Vec b, Vec x, Solve& solve) const {
  const auto ended = [this](Solve*) { now_ = nullptr; };
  const std::unique_ptr<Solve, decltype(ended)> under_way(now_ = &solve, ended);
  if (solve.project) {
    check(VecCopy(b, right_hand_side_));
    (*solve.project)(right_hand_side_);
    b = right_hand_side_;
  }
  check(KSPSolve(ksp_, b, x));
  if (solve.trial)
    return;
  count_solves();
  PetscInt iterations = 0;
  check(KSPGetIterationNumber(ksp_, &iterations));
  iterations_made += iterations;
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(ksp_, &reason));
  if (reason >= 0)
    return;
  PetscReal residual = 0;
  check(KSPGetResidualNorm(ksp_, &residual));
  throw SolverFailure(
      fmt::format("the solve with the step operator D by {} failed: {}, residual {:.3e} of {:.3e} after {} "
                  "iterations",
                  name(), KSPConvergedReasons[reason], residual, solve.scale, static_cast<int>(iterations)));
}

} // namespace signorini
