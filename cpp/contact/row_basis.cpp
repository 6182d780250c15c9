// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/row_basis.h"
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace signorini::contact {

std::size_t RowBasis::widest(const ConstraintRows& rows) {
  std::size_t most = 0;
  for (const ConstraintRows::Cluster& cluster : rows.clusters())
    most = std::max(most, cluster.width());
  return most;
}

RowBasis::RowBasis(const ConstraintRows& rows)
    : rows_(rows), capacity_(widest(rows)), q_(capacity_ * capacity_), R_(capacity_ * capacity_),
      members_(capacity_) {}

namespace {

double norm(std::span<const double> x) {
  constexpr std::size_t of_node = 3;
  if (x.size() <= of_node)
    return std::hypot(x[0], x.size() > 1 ? x[1] : 0, x.size() > 2 ? x[2] : 0);
  return std::sqrt(std::inner_product(x.begin(), x.end(), x.begin(), 0.0));
}

} // namespace

bool RowBasis::add(int row) {
  width_ = rows_.cluster(row).width();
  SmallArray<double, 3> whole(width_), part(capacity_);
  rows_.spread(row, whole);
  SmallArray<double, 3> left = whole;
  for (int pass = 0; pass < 2; ++pass) // the second pass removes the rounding of the first
    for (std::size_t k = 0; k < size_; ++k) {
      const double along_k = along(k, left);
      part[k] += along_k;
      for (std::size_t c = 0; c < width_; ++c)
        left[c] -= along_k * q_[k * capacity_ + c];
    }
  const double rest = norm(left);
  if (size_ == width_ || !(rest > dependence_limit * norm(whole)))
    return false;
  for (std::size_t c = 0; c < width_; ++c)
    q_[size_ * capacity_ + c] = left[c] / rest;
  part[size_] = rest;
  for (std::size_t k = 0; k < capacity_; ++k)
    R_[size_ * capacity_ + k] = part[k];
  members_[size_++] = row;
  return true;
}

void RowBasis::replace(std::size_t k, int row) {
  SmallArray<int, 3> members = members_;
  members[k] = row;
  const std::size_t size = std::exchange(size_, 0);
  for (std::size_t j = 0; j < size; ++j)
    add(members[j]);
}

double RowBasis::along(std::size_t k, std::span<const double> x) const {
  double sum = 0;
  for (std::size_t c = 0; c < width_; ++c)
    sum += q_[k * capacity_ + c] * x[c];
  return sum;
}

void RowBasis::coefficients(int row, Coordinates& out) const {
  SmallArray<double, 3> whole(width_);
  rows_.spread(row, whole);
  for (std::size_t k = 0; k < size_; ++k)
    out[k] = along(k, whole);
  combine(out);
}

void RowBasis::add_to(std::span<double> x, const Coordinates& b) const {
  for (std::size_t k = 0; k < size_; ++k)
    for (std::size_t c = 0; c < width_; ++c)
      x[c] += b[k] * q_[k * capacity_ + c];
}

void RowBasis::shortest(Coordinates& b) const {
  for (std::size_t j = 0; j < size_; ++j) {
    for (std::size_t k = 0; k < j; ++k)
      b[j] -= R_[j * capacity_ + k] * b[k];
    b[j] /= R_[j * capacity_ + j];
  }
}

void RowBasis::combine(Coordinates& b) const {
  for (std::size_t k = size_; k-- > 0;) {
    for (std::size_t j = k + 1; j < size_; ++j)
      b[k] -= R_[j * capacity_ + k] * b[j];
    b[k] /= R_[k * capacity_ + k];
  }
}

} // namespace signorini::contact
