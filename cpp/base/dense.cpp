#include "base/dense.h"
#include "base/error.h"
#include <cmath>
#include <petscblaslapack.h>

namespace signorini {

void solve_dense(std::vector<double> K, std::span<double> b) {
  const auto n = static_cast<PetscBLASInt>(std::lround(std::sqrt(static_cast<double>(K.size()))));
  if (n == 0)
    return;
  const auto columns = static_cast<PetscBLASInt>(b.size()) / n;
  PetscBLASInt info = 0;
  LAPACKpotrf_("L", &n, K.data(), &n, &info);
  if (info != 0)
    throw SolverFailure("a small dense matrix is not positive definite");
  LAPACKpotrs_("L", &n, &columns, K.data(), &n, b.data(), &n, &info);
}

} // namespace signorini
