// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/columns_on_demand.h"
#include "base/collective.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/signals.h"
#include "fem/operators.h"
#include <algorithm>

namespace signorini::contact {
using petsc::check;

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
  HalfSolve made;
  for (petsc::Vector* x : {&made.r, &made.y, &made.forces})
    *x = petsc::vector_of(matrix_);
  made.reference.resize(S_.size());
  made.weights.reserve(S_.size());
  made.columns.reserve(S_.size());
  return made;
}

void ColumnsOnDemand::prepare(std::span<const int> rows) const {
  for (const int row : rows) {
    std::vector<double>& S = S_[static_cast<std::size_t>(row)];
    if (!S.empty())
      continue;
    if (stop_requested(rows_.comm()))
      throw Interrupted();
    petsc::Vector force = petsc::vector_of(matrix_), y = petsc::zero_like(force);
    std::vector<double> unit(S_.size());
    unit[static_cast<std::size_t>(row)] = 1;
    rows_.apply(1, unit, force);
    D_.solve(force, y);
    std::vector<double> column(S_.size());
    rows_.apply_transpose(y, column);
    PetscInt n = 0;
    check(VecGetSize(y, &n));
    const double bytes = sizeof(double) * static_cast<double>(n);
    if (kept_ + bytes <= memory_) {
      columns_[static_cast<std::size_t>(row)] = std::move(y);
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
  std::vector<double>& weights = half_solve.weights;
  std::vector<Vec>& columns = half_solve.columns;
  weights.clear();
  columns.clear();
  bool kept = true;
  for (std::size_t i = 0; i < lambda.size(); ++i)
    if (const double change = lambda[i] - half_solve.reference[i]; change != 0) {
      weights.push_back(-change);
      columns.push_back(columns_[i]);
      kept = kept && columns_[i];
    }
  if (kept) {
    check(VecCopy(half_solve.y, y));
    check(VecMAXPY(y, static_cast<PetscInt>(columns.size()), weights.data(), columns.data()));
    return;
  }
  check(VecCopy(half_solve.r, half_solve.forces)); // from the guess, or what an earlier call returned
  rows_.apply(-1, lambda, half_solve.forces);
  D_.solve(half_solve.forces, y);
}

double ColumnsOnDemand::bytes() const {
  double known = 0;
  for (const std::vector<double>& S : S_)
    known += sizeof(double) * static_cast<double>(S.size());
  return kept_ + ranks(rows_.comm()) * known;
}

} // namespace signorini::contact
