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

Prediction ColumnsOnDemand::prediction() const {
  Prediction made;
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

void ColumnsOnDemand::predict(Vec r, const Guess& guess, Prediction& prediction,
                              std::span<double> motion) const {
  const std::vector<double>& rho = prediction.reference;
  check(VecCopy(r, prediction.r));
  check(VecCopy(guess.y, prediction.y));
  rows_.set_clamped(diagonal_, r, prediction.y);
  std::ranges::fill(prediction.reference, 0);
  if (!guess.active.empty()) {
    prepare(guess.active);
    check(MatMult(matrix_, prediction.y, prediction.forces));
    check(VecAYPX(prediction.forces, -1, r));
    rows_.multipliers(guess.active, prediction.forces, prediction.reference);
  }
  check(VecCopy(r, prediction.forces));
  rows_.apply(-1, rho, prediction.forces);
  D_.solve(prediction.forces, prediction.y);
  rows_.apply_transpose(prediction.y, motion);
  for (std::size_t i = 0; i < rho.size(); ++i)
    if (rho[i] != 0)
      for (std::size_t j = 0; j < motion.size(); ++j)
        motion[j] += rho[i] * S_[i][j];
}

void ColumnsOnDemand::finish(Prediction& prediction, std::span<const double> lambda, Vec y) const {
  std::vector<double>& weights = prediction.weights;
  std::vector<Vec>& columns = prediction.columns;
  weights.clear();
  columns.clear();
  bool kept = true;
  for (std::size_t i = 0; i < lambda.size(); ++i)
    if (const double change = lambda[i] - prediction.reference[i]; change != 0) {
      weights.push_back(-change);
      columns.push_back(columns_[i]);
      kept = kept && columns_[i];
    }
  if (kept) {
    check(VecCopy(prediction.y, y));
    check(VecMAXPY(y, static_cast<PetscInt>(columns.size()), weights.data(), columns.data()));
    return;
  }
  check(VecCopy(prediction.r, prediction.forces)); // from the guess, or what an earlier call returned
  rows_.apply(-1, lambda, prediction.forces);
  D_.solve(prediction.forces, y);
}

double ColumnsOnDemand::bytes() const {
  double known = 0;
  for (const std::vector<double>& S : S_)
    known += sizeof(double) * static_cast<double>(S.size());
  return kept_ + ranks(rows_.comm()) * known;
}

} // namespace signorini::contact
