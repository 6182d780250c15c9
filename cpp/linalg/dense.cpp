// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/dense.h"
#include "base/error.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <petscblaslapack.h>

namespace signorini {

int factorise_dense(std::span<double> K, std::size_t n) {
  const auto size = static_cast<PetscBLASInt>(n);
  PetscBLASInt info = 0;
  if (n > 0)
    LAPACKpotrf_("L", &size, K.data(), &size, &info);
  return static_cast<int>(info);
}

void solve_factorised(std::span<const double> factor, std::size_t n, std::span<double> b) {
  if (n == 0)
    return;
  const auto size = static_cast<PetscBLASInt>(n), columns = static_cast<PetscBLASInt>(b.size() / n);
  PetscBLASInt info = 0;
  LAPACKpotrs_("L", &size, &columns, factor.data(), &size, b.data(), &size, &info);
}

int invert_factorised(std::span<double> factor, std::size_t n) {
  const auto size = static_cast<PetscBLASInt>(n);
  PetscBLASInt info = 0;
  if (n > 0)
    LAPACKpotri_("L", &size, factor.data(), &size, &info);
  for (std::size_t j = 0; j < n; ++j) // LAPACK fills the lower triangle only
    for (std::size_t i = j + 1; i < n; ++i)
      factor[i * n + j] = factor[j * n + i];
  return static_cast<int>(info);
}

std::vector<double> symmetric_eigenvalues(std::span<double> K, std::size_t n) {
  std::vector<double> values(n), work(std::max<std::size_t>(1, 3 * n));
  const auto size = static_cast<PetscBLASInt>(n), length = static_cast<PetscBLASInt>(work.size());
  PetscBLASInt info = 0;
  if (n > 0)
    LAPACKsyev_("V", "L", &size, K.data(), &size, values.data(), work.data(), &length, &info);
  if (info != 0)
    throw SolverFailure("the eigenvalues of a dense matrix did not converge");
  return values;
}

bool solve_dense(std::vector<double> K, std::span<double> b) {
  const auto n = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(K.size()))));
  if (factorise_dense(K, n) != 0)
    return false;
  solve_factorised(K, n, b);
  return true;
}

int solve_general(std::span<double> K, std::size_t n, bool transposed, std::span<double> b, int* sign) {
  if (sign)
    *sign = 1;
  if (n == 0)
    return 0;
  std::vector<PetscBLASInt> pivots(n);
  const auto size = static_cast<PetscBLASInt>(n), columns = static_cast<PetscBLASInt>(b.size() / n);
  PetscBLASInt info = 0;
  LAPACKgetrf_(&size, &size, K.data(), &size, pivots.data(), &info);
  if (sign)
    for (std::size_t i = 0; i < n; ++i)
      *sign *= (K[i * n + i] < 0) == (pivots[i] == static_cast<PetscBLASInt>(i) + 1) ? -1 : 1;
  if (info == 0)
    LAPACKgetrs_(transposed ? "T" : "N", &size, &columns, K.data(), &size, pivots.data(), b.data(), &size,
                 &info);
  return static_cast<int>(info);
}

namespace {

constexpr PetscBLASInt one = 1;

/// Calls part(first, count) for consecutive ranges that cover 0 … size − 1, each short enough for the BLAS.
template <class Part>
void in_parts(std::size_t size, Part&& part) {
  constexpr std::size_t most = 1 << 30; // BLAS counts with 32-bit integers
  for (std::size_t first = 0; first < size; first += most)
    part(first, static_cast<PetscBLASInt>(std::min(most, size - first)));
}

/// Number of arrays x_i that one pass over y processes.
constexpr std::size_t together = 4;

void add(const double* a, const float* const* x, std::span<double> y) {
  const float *x0 = x[0], *x1 = x[1], *x2 = x[2], *x3 = x[3];
  double* to = y.data();
#pragma omp simd
  for (std::size_t i = 0; i < y.size(); ++i)
    to[i] += (a[0] * x0[i] + a[1] * x1[i]) + (a[2] * x2[i] + a[3] * x3[i]);
}

std::array<double, together> dots(const float* const* x, std::span<const double> y) {
  const float *x0 = x[0], *x1 = x[1], *x2 = x[2], *x3 = x[3];
  const double* with = y.data();
  double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
#pragma omp simd reduction(+ : s0, s1, s2, s3)
  for (std::size_t i = 0; i < y.size(); ++i) {
    s0 += x0[i] * with[i];
    s1 += x1[i] * with[i];
    s2 += x2[i] * with[i];
    s3 += x3[i] * with[i];
  }
  return {s0, s1, s2, s3};
}

} // namespace

void axpy(double a, std::span<const double> x, std::span<double> y) {
  in_parts(x.size(), [&](std::size_t first, PetscBLASInt count) {
    BLASaxpy_(&count, &a, &x[first], &one, &y[first], &one);
  });
}

void scale(double a, std::span<double> x) {
  in_parts(x.size(), [&](std::size_t first, PetscBLASInt count) { BLASscal_(&count, &a, &x[first], &one); });
}

double dot(std::span<const double> x, std::span<const double> y) {
  double sum = 0;
  in_parts(x.size(), [&](std::size_t first, PetscBLASInt count) {
    sum += BLASdot_(&count, &x[first], &one, &y[first], &one);
  });
  return sum;
}

void add(std::span<const double> a, std::span<const float* const> x, std::span<double> y) {
  for (std::size_t first = 0; first < x.size(); first += together) {
    const std::size_t count = std::min(together, x.size() - first);
    std::array<double, together> factors{};
    std::array<const float*, together> arrays{};
    arrays.fill(x[first]); // with the factor zero
    std::copy_n(&a[first], count, factors.begin());
    std::copy_n(&x[first], count, arrays.begin());
    add(factors.data(), arrays.data(), y);
  }
}

void dots(std::span<const float* const> x, std::span<const double> y, std::span<double> products) {
  for (std::size_t first = 0; first < x.size(); first += together) {
    const std::size_t count = std::min(together, x.size() - first);
    std::array<const float*, together> arrays{};
    arrays.fill(x[first]);
    std::copy_n(&x[first], count, arrays.begin());
    std::copy_n(dots(arrays.data(), y).begin(), count, &products[first]);
  }
}

void multiply(std::span<const double> A, std::span<const double> B, std::span<double> C, std::size_t n) {
  const auto inner = static_cast<PetscBLASInt>(n), rows = static_cast<PetscBLASInt>(A.size() / n),
             columns = static_cast<PetscBLASInt>(B.size() / n);
  const double one = 1, zero = 0;
  BLASgemm_("N", "N", &rows, &columns, &inner, &one, A.data(), &rows, B.data(), &inner, &zero, C.data(),
            &rows);
}

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
