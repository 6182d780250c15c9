#include "contact/elimination.h"
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

} // namespace

TrailingBlockElimination::TrailingBlockElimination(const Constraints& constraints, const SparseCholesky& D)
    : constraints_(constraints), D_(D), L_(D.corner_factor()), z_(static_cast<std::size_t>(D.corner_size())),
      corner_(z_.size()) {}

void TrailingBlockElimination::predict(Vec r, std::span<double> normal) const {
  std::ranges::copy(D_.forward(r), z_.begin());
  corner_ = z_;
  triangular(L_, "T", corner_);
  const auto dim = static_cast<std::size_t>(constraints_.dim());
  for (std::size_t i = 0; i < normal.size(); ++i) {
    const auto node = static_cast<std::size_t>(constraints_.nodes()[i]);
    normal[i] = 0;
    for (std::size_t c = 0; c < dim; ++c)
      normal[i] += constraints_.normals()[i * dim + c] * corner_[node * dim + c];
  }
}

void TrailingBlockElimination::finish(std::span<const double> lambda, Vec y) const {
  if (std::ranges::all_of(lambda, [](double force) { return force == 0; })) {
    D_.backward(z_, y);
    return;
  }
  const auto dim = static_cast<std::size_t>(constraints_.dim());
  std::ranges::fill(corner_, 0);
  for (std::size_t i = 0; i < lambda.size(); ++i) {
    const auto node = static_cast<std::size_t>(constraints_.nodes()[i]);
    for (std::size_t c = 0; c < dim; ++c)
      corner_[node * dim + c] += constraints_.directions()[i * dim + c] * lambda[i];
  }
  triangular(L_, "N", corner_);
  for (std::size_t i = 0; i < corner_.size(); ++i)
    corner_[i] = z_[i] - corner_[i];
  D_.backward(corner_, y);
}

std::vector<double> TrailingBlockElimination::condensed() const {
  const auto m = static_cast<std::size_t>(constraints_.count()),
             dim = static_cast<std::size_t>(constraints_.dim()), c = z_.size();
  std::vector<double> X(c * m, 0.0), S(m * m, 0.0); // X = L⁻¹N
  for (std::size_t i = 0; i < m; ++i)
    for (std::size_t k = 0; k < dim; ++k)
      X[i * c + static_cast<std::size_t>(constraints_.nodes()[i]) * dim + k] =
          constraints_.directions()[i * dim + k];
  const auto rows = static_cast<PetscBLASInt>(c), columns = static_cast<PetscBLASInt>(m);
  const double one = 1, zero = 0;
  BLAStrsm_("L", "L", "N", "N", &rows, &columns, &one, L_.data(), &rows, X.data(), &rows);
  BLASsyrk_("L", "T", &columns, &rows, &one, X.data(), &rows, &zero, S.data(), &columns);
  for (std::size_t j = 0; j < m; ++j) // the BLAS fills the lower triangle, column by column
    for (std::size_t i = j + 1; i < m; ++i)
      S[i * m + j] = S[j * m + i];
  return S;
}

double TrailingBlockElimination::bytes() const { return sizeof(double) * static_cast<double>(L_.size()); }

StoredColumnsElimination::StoredColumnsElimination(const Constraints& constraints, const LinearSolver& D,
                                                   Vec layout, double memory)
    : constraints_(constraints), D_(D), r_(petsc::zero_like(layout)), y_(petsc::zero_like(layout)),
      work_(petsc::zero_like(layout)) {
  const auto m = static_cast<std::size_t>(constraints.count());
  PetscInt n = 0;
  check(VecGetSize(layout, &n));
  const bool keep = sizeof(double) * static_cast<double>(m) * static_cast<double>(n) <= memory;
  S_.resize(m * m);
  std::vector<double> unit(m, 0.0);
  for (std::size_t j = 0; j < m; ++j) {
    if (stop_requested(petsc::comm(layout)))
      throw Interrupted();
    check(VecZeroEntries(r_));
    unit[j] = 1;
    constraints.add_normal(1, unit, r_);
    unit[j] = 0;
    D.solve(r_, y_);
    constraints.normal_components(y_, std::span(&S_[j * m], m));
    if (keep)
      columns_.push_back(petsc::copy(y_));
  }
  for (std::size_t i = 0; i < m; ++i) // rounding of the solves is the only asymmetry
    for (std::size_t j = 0; j < i; ++j)
      S_[i * m + j] = S_[j * m + i] = (S_[i * m + j] + S_[j * m + i]) / 2;
  weights_.reserve(m);
  used_.reserve(m);
}

void StoredColumnsElimination::predict(Vec r, std::span<double> normal) const {
  check(VecCopy(r, r_));
  D_.solve(r, y_);
  constraints_.normal_components(y_, normal);
}

void StoredColumnsElimination::finish(std::span<const double> lambda, Vec y) const {
  weights_.clear();
  used_.clear();
  for (std::size_t i = 0; i < lambda.size(); ++i)
    if (lambda[i] != 0) {
      weights_.push_back(-lambda[i]);
      if (!columns_.empty())
        used_.push_back(columns_[i]);
    }
  check(VecCopy(y_, y));
  if (weights_.empty())
    return;
  if (!columns_.empty()) {
    check(VecMAXPY(y, static_cast<PetscInt>(used_.size()), weights_.data(), used_.data()));
    return;
  }
  check(VecCopy(r_, work_));
  constraints_.add_normal(-1, lambda, work_);
  D_.solve(work_, y);
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
