// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/elimination.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/signals.h"
#include <algorithm>
#include <petscblaslapack.h>

namespace signorini::contact {
using petsc::check;

namespace {

/// x ← L⁻¹ x or L⁻ᵀ x with a dense lower triangular L.
void triangular(const std::vector<double>& L, const char* transposed, std::span<double> x) {
  const auto n = static_cast<PetscBLASInt>(x.size());
  const PetscBLASInt one = 1;
  if (n > 0)
    BLAStrsv_("L", transposed, "N", &n, L.data(), &n, x.data(), &one);
}

/// Columns of H solved at a time: enough for MUMPS to work by dense products, few enough for the block to
/// take little memory beside the factor.
constexpr int block = 64;

} // namespace

TrailingBlockElimination::TrailingBlockElimination(const ConstraintRows& rows, const SparseCholesky& D)
    : WholeElimination(rows), D_(D), L_(D.corner_factor()) {
  condense();
}

Prediction TrailingBlockElimination::prediction() const {
  Prediction made;
  made.z.resize(D_.size());
  made.corner.resize(static_cast<std::size_t>(D_.corner_size()));
  return made;
}

void TrailingBlockElimination::predict(Vec r, const Guess&, Prediction& prediction,
                                       std::span<double> motion) const {
  std::vector<double>&z = prediction.z, &corner = prediction.corner;
  D_.forward(r, z);
  std::copy(z.end() - static_cast<std::ptrdiff_t>(corner.size()), z.end(), corner.begin());
  triangular(L_, "T", corner);
  rows_.apply_transpose(corner, motion);
}

void TrailingBlockElimination::finish(Prediction& prediction, std::span<const double> lambda, Vec y) const {
  const std::vector<double>& z = prediction.z;
  if (std::ranges::all_of(lambda, [](double force) { return force == 0; })) {
    D_.backward(z, {}, y);
    return;
  }
  std::vector<double>& corner = prediction.corner;
  rows_.apply(lambda, corner);
  triangular(L_, "N", corner);
  const std::size_t before = z.size() - corner.size();
  for (std::size_t i = 0; i < corner.size(); ++i)
    corner[i] = z[before + i] - corner[i];
  D_.backward(z, corner, y);
}

void TrailingBlockElimination::condense() {
  const auto m = static_cast<std::size_t>(rows_.count()), c = static_cast<std::size_t>(D_.corner_size());
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

double TrailingBlockElimination::bytes() const { return sizeof(double) * static_cast<double>(L_.size()); }

StoredColumnsElimination::StoredColumnsElimination(const ConstraintRows& rows, const MumpsSolver& D,
                                                   Vec layout, double memory)
    : WholeElimination(rows), D_(D), layout_(petsc::zero_like(layout)) {
  const auto m = static_cast<std::size_t>(rows.count());
  PetscInt n = 0;
  check(VecGetSize(layout, &n));
  const bool keep = sizeof(double) * static_cast<double>(m) * static_cast<double>(n) <= memory;
  S_.resize(m * m);
  for (int first = 0; first < rows.count(); first += block) {
    if (stop_requested(petsc::comm(layout)))
      throw Interrupted();
    const int count = std::min(block, rows.count() - first);
    const petsc::Matrix X = D.solve_sparse(rows.rows(first, count, layout));
    for (int j = 0; j < count; ++j) {
      const petsc::Column y(X, j);
      rows_.apply_transpose(y, std::span(&S_[static_cast<std::size_t>(first + j) * m], m));
      if (keep)
        columns_.push_back(petsc::copy(y));
    }
  }
  for (std::size_t i = 0; i < m; ++i) // rounding of the solves is the only asymmetry
    for (std::size_t j = 0; j < i; ++j)
      S_[i * m + j] = S_[j * m + i] = (S_[i * m + j] + S_[j * m + i]) / 2;
}

Prediction StoredColumnsElimination::prediction() const {
  Prediction made;
  for (petsc::Vector* x : {&made.r, &made.y, &made.forces})
    *x = petsc::zero_like(layout_);
  made.weights.reserve(static_cast<std::size_t>(rows_.count()));
  made.columns.reserve(static_cast<std::size_t>(rows_.count()));
  return made;
}

void StoredColumnsElimination::predict(Vec r, const Guess&, Prediction& prediction,
                                       std::span<double> motion) const {
  check(VecCopy(r, prediction.r));
  D_.solve(r, prediction.y);
  rows_.apply_transpose(prediction.y, motion);
}

void StoredColumnsElimination::finish(Prediction& prediction, std::span<const double> lambda, Vec y) const {
  std::vector<double>& weights = prediction.weights;
  std::vector<Vec>& columns = prediction.columns;
  weights.clear();
  columns.clear();
  for (std::size_t i = 0; i < lambda.size(); ++i)
    if (lambda[i] != 0) {
      weights.push_back(-lambda[i]);
      if (!columns_.empty())
        columns.push_back(columns_[i]);
    }
  check(VecCopy(prediction.y, y));
  if (weights.empty())
    return;
  if (!columns_.empty()) {
    check(VecMAXPY(y, static_cast<PetscInt>(columns.size()), weights.data(), columns.data()));
    return;
  }
  check(VecCopy(prediction.r, prediction.forces));
  rows_.apply(-1, lambda, prediction.forces);
  D_.solve(prediction.forces, y);
}

double StoredColumnsElimination::bytes() const {
  double sum = 0;
  for (const petsc::Vector& column : columns_) {
    PetscInt n = 0;
    check(VecGetSize(column, &n));
    sum += sizeof(double) * static_cast<double>(n);
  }
  return sum;
}

} // namespace signorini::contact
