// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/conjugate_gradients.h"
#include "base/error.h"
#include "base/timers.h"
#include "linalg/threaded_product.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <string_view>

namespace signorini {
using petsc::check;

namespace {

/// Copies a matrix to AIJ format together with its near null space. Collective.
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
  check(PetscOptionsHasName(nullptr, LinearSolver::prefix, "-pc_type", &given));
  return given != PETSC_FALSE;
}

Preconditioner::Preconditioner(Mat matrix, Kind kind) {
  check(PCCreate(petsc::comm(matrix), preconditioner_.put()));
  check(PCSetOptionsPrefix(preconditioner_, LinearSolver::prefix));
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

namespace {

long& iterations_made = count("iterations of conjugate gradients");
/// Relative residuals below which the termination test is called: at the first, most changes of the active
/// set already show.
constexpr std::array judged_at{1e-3, 1e-6};

} // namespace

ConjugateGradients::ConjugateGradients(Mat matrix, double solves, double most)
    : matrix_(matrix), right_hand_side_(petsc::vector_of(matrix)), projected_(petsc::vector_of(matrix)) {
  PetscInt owned = 0;
  check(MatGetLocalSize(matrix, &owned, nullptr));
  PetscBool blocks = PETSC_FALSE;
  check(
      PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(matrix), &blocks, MATSEQBAIJ, MATMPIBAIJ, ""));
  if (blocks)
    half_ = symmetric_half(matrix);
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
  // Work of an iteration by multigrid, and of its set-up, in iterations by block Jacobi; from the long steps
  // of `./dev bench courant`.
  constexpr double cycle = 22, setup = 600;
  constexpr double few = 5 * cycle; // multigrid takes five iterations at least
  preconditioner_ = std::make_unique<Preconditioner>(matrix, Preconditioner::Kind::block_jacobi);
  trial_work_ = try_out(most);
  if (Preconditioner::given_by_options()) {
    trial_work_ *= 1 + preconditioner_->bytes() / iteration_bytes(matrix);
    return;
  }
  if (trial_work_ <= few || solves * trial_work_ < setup)
    return;
  auto multigrid = std::make_unique<Preconditioner>(matrix, Preconditioner::Kind::multigrid);
  std::swap(preconditioner_, multigrid);
  if (const double work = cycle * try_out(most / cycle);
      std::isfinite(work) && setup + solves * work <= solves * trial_work_)
    trial_work_ = work;
  else
    std::swap(preconditioner_, multigrid);
}

double ConjugateGradients::iteration_bytes(Mat matrix) {
  // x, r, p and D p are read or written twice, the blocks of Jacobi and their results once, and half of D.
  constexpr double vectors = 10;
  PetscInt n = 0;
  check(MatGetSize(matrix, &n, nullptr));
  return petsc::bytes(matrix) / 2 + vectors * sizeof(PetscScalar) * static_cast<double>(n);
}

double ConjugateGradients::try_out(double most) const {
  const petsc::Vector x = petsc::zero_like(projected_), b = petsc::zero_like(projected_);
  check(VecSet(b, 1));
  Solve solve{.most = most};
  run(b, x, solve);
  PetscInt iterations = 0;
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetIterationNumber(ksp_, &iterations));
  check(KSPGetConvergedReason(ksp_, &reason));
  return reason < 0 ? std::numeric_limits<double>::infinity() : static_cast<double>(iterations);
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
  PetscCall(MatMult(self.product(), x, y));
  if (!self.now_->started) { // x is the guess; b·x would leave out the forces of constraints
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
  if (!std::isfinite(residual)) {
    *reason = KSP_DIVERGED_NANORINF;
  } else if (residual <= self.tolerance_ * now.scale) {
    *reason = KSP_CONVERGED_RTOL;
  } else if (now.most && iteration >= *now.most) {
    *reason = KSP_DIVERGED_ITS;
  } else if (now.termination_test && due > now.limits_passed) {
    now.limits_passed = due;
    Vec x = nullptr;
    PetscCall(KSPBuildSolution(ksp, nullptr, &x));
    try {
      now.stopped = !(*now.termination_test)(x);
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

bool ConjugateGradients::solve(Vec b, Vec x, const Projector& project,
                               const TerminationTest& termination_test) const {
  Solve solve{.project = &project, .termination_test = termination_test ? &termination_test : nullptr};
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
  if (solve.most)
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
  throw SolverFailure(fmt::format(
      "the solve with the step operator D by {} failed: {}, residual {:.3e}, limit {:.3e}, after "
      "{} iterations",
      name(), KSPConvergedReasons[reason], residual, tolerance_ * solve.scale, static_cast<int>(iterations)));
}

} // namespace signorini
