// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/updated_cholesky.h"
#include "linalg/dense.h"
#include <algorithm>
#include <cmath>

namespace signorini {

void UpdatedCholesky::clear() {
  size_ = 0;
  R_.clear();
}

void UpdatedCholesky::forward(std::span<double> x) const {
  for (std::size_t j = 0; j < size_; ++j)
    x[j] = (x[j] - dot(std::span(R_).subspan(start(j), j), x.first(j))) / R_[start(j) + j];
}

bool UpdatedCholesky::append(std::span<const double> column, double diagonal, double negligible) {
  R_.insert(R_.end(), column.begin(), column.end());
  const std::span<double> appended = std::span(R_).subspan(start(size_));
  forward(appended);
  const double pivot = diagonal - dot(appended, appended);
  if (!(pivot > negligible * diagonal)) {
    R_.resize(start(size_));
    return false;
  }
  R_.push_back(std::sqrt(pivot));
  ++size_;
  return true;
}

void UpdatedCholesky::remove(std::size_t i) {
  // Without column i the later ones reach one row below the diagonal, from which rotations of neighbouring
  // rows remove them.
  rotations_.clear();
  for (std::size_t j = i + 1; j < size_; ++j) {
    double* row = &R_[start(j) + i];
    for (const auto& [cosine, sine] : rotations_) {
      const double upper = row[0], lower = row[1];
      row[0] = cosine * upper + sine * lower;
      row[1] = cosine * lower - sine * upper;
      ++row;
    }
    const double length = std::hypot(row[0], row[1]);
    rotations_.push_back({row[0] / length, row[1] / length});
    row[0] = length;
    std::copy_n(&R_[start(j)], j, &R_[start(j - 1)]);
  }
  R_.resize(start(--size_));
}

void UpdatedCholesky::solve(std::span<double> b) const {
  forward(b);
  for (std::size_t j = size_; j-- > 0;) {
    b[j] /= R_[start(j) + j];
    axpy(-b[j], std::span(R_).subspan(start(j), j), b.first(j));
  }
}

} // namespace signorini
