// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/blas.h"
#include <algorithm>
#include <array>
#include <petscblaslapack.h>

namespace signorini {
namespace {

constexpr PetscBLASInt one = 1;

/// Calls part(first, count) on consecutive ranges of 0 … size − 1, each short enough for BLAS.
template <class Part>
void in_parts(std::size_t size, Part&& part) {
  constexpr std::size_t most = 1 << 30; // BLAS counts with 32-bit integers
  for (std::size_t first = 0; first < size; first += most)
    part(first, static_cast<PetscBLASInt>(std::min(most, size - first)));
}

/// Arrays that one pass over the common one takes.
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

} // namespace signorini
