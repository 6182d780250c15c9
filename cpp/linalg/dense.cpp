// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/dense.h"
#include "base/error.h"
#include <algorithm>
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

int solve_general(std::span<double> K, std::size_t n, bool transposed, std::span<double> b) {
  if (n == 0)
    return 0;
  std::vector<PetscBLASInt> pivots(n);
  const auto size = static_cast<PetscBLASInt>(n), columns = static_cast<PetscBLASInt>(b.size() / n);
  PetscBLASInt info = 0;
  LAPACKgetrf_(&size, &size, K.data(), &size, pivots.data(), &info);
  if (info == 0)
    LAPACKgetrs_(transposed ? "T" : "N", &size, &columns, K.data(), &size, pivots.data(), b.data(), &size,
                 &info);
  return static_cast<int>(info);
}

} // namespace signorini
