// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/mumps_solver.h"
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
constexpr double megabyte = 1e6; // the unit of INFOG(17) and INFOG(22)
} // namespace

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
  // MUMPS rounds to whole megabytes.
  return std::max(megabyte * static_cast<double>(megabytes), sizeof(double) * work().entries);
}

FactorWork MumpsSolver::work() const {
  constexpr double million =
      1e6; // MUMPS returns counts beyond the range of an integer in millions, as negative numbers
  FactorWork work;
  PetscInt entries = 0;
  check(MatMumpsGetRinfog(factor_, 1, &work.flops));
  check(MatMumpsGetInfog(factor_, 20, &entries));
  work.entries = entries < 0 ? -million * static_cast<double>(entries) : static_cast<double>(entries);
  return work;
}

void MumpsSolver::factorise() {
  // MUMPS divides the work by the ranks' loads at the time, so that the space estimated by the analysis may
  // fall short, at random. Space that is not used costs no memory: twice as much is reserved, and more if
  // that, or the user's own option, is too little.
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

} // namespace signorini
