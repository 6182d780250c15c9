// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/condensation.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/signals.h"
#include "base/timers.h"
#include "fem/operators.h"
#include <algorithm>
#include <petscblaslapack.h>

namespace signorini::contact {
using petsc::check;

namespace {

/// Solves with a dense lower triangular L in place: replaces x by L⁻¹ x or, for `transposed` = "T", by L⁻ᵀ x.
void triangular(const std::vector<double>& L, const char* transposed, std::span<double> x) {
  const auto n = static_cast<PetscBLASInt>(x.size());
  const PetscBLASInt one = 1;
  if (n > 0)
    BLAStrsv_("L", transposed, "N", &n, L.data(), &n, x.data(), &one);
}

/// Number of columns of H that are solved for at once: enough for MUMPS to use dense products, few enough to
/// take little memory in comparison with the factor.
constexpr int block = 64;

HalfSolve half_solve_by_columns(Vec layout, int rows) {
  HalfSolve made;
  for (petsc::Vector* x : {&made.r, &made.y, &made.forces})
    *x = petsc::zero_like(layout);
  made.reference.resize(static_cast<std::size_t>(rows));
  made.weights.reserve(made.reference.size());
  made.columns.reserve(made.reference.size());
  return made;
}

/// Computes y = D⁻¹ (r − Hλ) from half_solve.y, the solution for the multipliers half_solve.reference, by
/// adding columns of D⁻¹H. If a column that is needed is not stored, solves with D instead, starting from the
/// guess y.
void finish_by_columns(const ConstraintRows& rows, const petsc::Series& stored, const LinearSolver& D,
                       HalfSolve& half_solve, std::span<const double> lambda, Vec y) {
  std::vector<double>& weights = half_solve.weights;
  std::vector<Vec>& columns = half_solve.columns;
  weights.clear();
  columns.clear();
  bool all_stored = true;
  for (std::size_t i = 0; i < lambda.size(); ++i)
    if (const double change = lambda[i] - half_solve.reference[i]; change != 0) {
      weights.push_back(-change);
      columns.push_back(stored[i]);
      all_stored = all_stored && stored[i];
    }
  if (all_stored) {
    check(VecCopy(half_solve.y, y));
    check(VecMAXPY(y, static_cast<PetscInt>(columns.size()), weights.data(), columns.data()));
    return;
  }
  check(VecCopy(half_solve.r, half_solve.forces));
  rows.apply(-1, lambda, half_solve.forces);
  D.solve(half_solve.forces, y);
}

} // namespace

TrailingBlockCondensation::TrailingBlockCondensation(const ConstraintRows& rows, const SparseCholesky& D)
    : WholeCondensation(rows), D_(D), L_(D.trailing_factor()) {
  condense();
}

HalfSolve TrailingBlockCondensation::half_solve() const {
  HalfSolve made;
  made.z = D_.storage();
  made.trailing_block.resize(static_cast<std::size_t>(D_.trailing_size()));
  return made;
}

void TrailingBlockCondensation::predict(Vec r, const Guess&, HalfSolve& half_solve,
                                        std::span<double> motion) const {
  std::vector<double>& trailing_block = half_solve.trailing_block;
  D_.forward(r, half_solve.z);
  std::ranges::copy(half_solve.z.trailing_block(), trailing_block.begin());
  triangular(L_, "T", trailing_block);
  rows_.apply_transpose(trailing_block, motion);
}

void TrailingBlockCondensation::finish(HalfSolve& half_solve, std::span<const double> lambda, Vec y) const {
  const SparseCholesky::Forward& z = half_solve.z;
  if (std::ranges::all_of(lambda, [](double force) { return force == 0; })) {
    D_.backward(z, {}, y);
    return;
  }
  std::vector<double>& trailing_block = half_solve.trailing_block;
  rows_.apply(lambda, trailing_block);
  triangular(L_, "N", trailing_block);
  for (std::size_t i = 0; i < trailing_block.size(); ++i)
    trailing_block[i] = z.trailing_block()[i] - trailing_block[i];
  D_.backward(z, trailing_block, y);
}

void TrailingBlockCondensation::condense() {
  const auto m = static_cast<std::size_t>(rows_.count()), c = static_cast<std::size_t>(D_.trailing_size());
  std::vector<double> X = rows_.dense(); // L⁻¹H
  S_.resize(m * m);
  const auto height = static_cast<PetscBLASInt>(c), columns = static_cast<PetscBLASInt>(m);
  const double one = 1, zero = 0;
  BLAStrsm_("L", "L", "N", "N", &height, &columns, &one, L_.data(), &height, X.data(), &height);
  BLASsyrk_("L", "T", &columns, &height, &one, X.data(), &height, &zero, S_.data(), &columns);
  for (std::size_t j = 0; j < m; ++j) // the BLAS fills the lower triangle, column by column
    for (std::size_t i = j + 1; i < m; ++i)
      S_[i * m + j] = S_[j * m + i];
}

double TrailingBlockCondensation::bytes() const { return sizeof(double) * static_cast<double>(L_.size()); }

StoredColumnsCondensation::StoredColumnsCondensation(const ConstraintRows& rows, const MumpsSolver& D,
                                                     Vec layout, double memory)
    : WholeCondensation(rows), D_(D), layout_(petsc::zero_like(layout)) {
  const auto m = static_cast<std::size_t>(rows.count());
  PetscInt n = 0;
  check(VecGetSize(layout, &n));
  const bool keep = sizeof(double) * static_cast<double>(m) * static_cast<double>(n) <= memory;
  S_.resize(m * m);
  columns_.resize(m);
  for (int first = 0; first < rows.count(); first += block) {
    if (stop_requested(petsc::comm(layout)))
      throw Interrupted();
    const int count = std::min(block, rows.count() - first);
    const petsc::Matrix X = D.solve_sparse(rows.rows(first, count, layout));
    for (int j = 0; j < count; ++j) {
      const petsc::Column y(X, j);
      rows_.apply_transpose(y, std::span(&S_[static_cast<std::size_t>(first + j) * m], m));
      if (keep)
        columns_[first + j] = petsc::copy(y);
    }
  }
  for (std::size_t i = 0; i < m; ++i) // rounding of the solves is the only asymmetry
    for (std::size_t j = 0; j < i; ++j)
      S_[i * m + j] = S_[j * m + i] = (S_[i * m + j] + S_[j * m + i]) / 2;
}

HalfSolve StoredColumnsCondensation::half_solve() const {
  return half_solve_by_columns(layout_, rows_.count());
}

void StoredColumnsCondensation::predict(Vec r, const Guess&, HalfSolve& half_solve,
                                        std::span<double> motion) const {
  check(VecCopy(r, half_solve.r));
  D_.solve(r, half_solve.y);
  rows_.apply_transpose(half_solve.y, motion);
}

void StoredColumnsCondensation::finish(HalfSolve& half_solve, std::span<const double> lambda, Vec y) const {
  finish_by_columns(rows_, columns_, D_, half_solve, lambda, y);
}

double StoredColumnsCondensation::bytes() const {
  PetscInt n = 0;
  check(VecGetSize(layout_, &n));
  const auto stored = std::ranges::count_if(columns_, [](Vec column) { return column != nullptr; });
  return sizeof(double) * static_cast<double>(n) * static_cast<double>(stored);
}

namespace {
long& solved = count("columns on demand");
}

ColumnsOnDemand::ColumnsOnDemand(const ConstraintRows& rows, const ConjugateGradients& D, Mat matrix,
                                 double memory)
    : rows_(rows), D_(D), matrix_(matrix), memory_(memory), S_(static_cast<std::size_t>(rows.count())),
      columns_(S_.size()) {
  if (rows.clamped())
    diagonal_ = fem::diagonal(matrix);
}

HalfSolve ColumnsOnDemand::half_solve() const {
  return half_solve_by_columns(petsc::vector_of(matrix_), rows_.count());
}

void ColumnsOnDemand::prepare(std::span<const int> rows) const {
  for (const int row : rows) {
    std::vector<double>& S = S_[row];
    if (!S.empty())
      continue;
    if (stop_requested(rows_.comm()))
      throw Interrupted();
    petsc::Vector force = petsc::vector_of(matrix_), y = petsc::zero_like(force);
    std::vector<double> unit(S_.size());
    unit[row] = 1;
    rows_.apply(1, unit, force);
    D_.solve(force, y);
    std::vector<double> column(S_.size());
    rows_.apply_transpose(y, column);
    PetscInt n = 0;
    check(VecGetSize(y, &n));
    const double bytes = sizeof(double) * static_cast<double>(n);
    if (kept_ + bytes <= memory_) {
      columns_[row] = std::move(y);
      kept_ += bytes;
    }
    S = std::move(column);
    ++solved;
  }
}

void ColumnsOnDemand::predict(Vec r, const Guess& guess, HalfSolve& half_solve,
                              std::span<double> motion) const {
  const std::vector<double>& rho = half_solve.reference;
  check(VecCopy(r, half_solve.r));
  check(VecCopy(guess.y, half_solve.y));
  rows_.set_clamped(diagonal_, r, half_solve.y);
  std::ranges::fill(half_solve.reference, 0);
  if (!guess.active.empty()) {
    prepare(guess.active);
    check(MatMult(matrix_, half_solve.y, half_solve.forces));
    check(VecAYPX(half_solve.forces, -1, r));
    rows_.multipliers(guess.active, half_solve.forces, half_solve.reference);
  }
  check(VecCopy(r, half_solve.forces));
  rows_.apply(-1, rho, half_solve.forces);
  D_.solve(half_solve.forces, half_solve.y);
  rows_.apply_transpose(half_solve.y, motion);
  for (std::size_t i = 0; i < rho.size(); ++i)
    if (rho[i] != 0)
      for (std::size_t j = 0; j < motion.size(); ++j)
        motion[j] += rho[i] * S_[i][j];
}

void ColumnsOnDemand::finish(HalfSolve& half_solve, std::span<const double> lambda, Vec y) const {
  finish_by_columns(rows_, columns_, D_, half_solve, lambda, y);
}

double ColumnsOnDemand::bytes() const {
  double known = 0;
  for (const std::vector<double>& S : S_)
    known += sizeof(double) * static_cast<double>(S.size());
  return kept_ + ranks(rows_.comm()) * known;
}

} // namespace signorini::contact
