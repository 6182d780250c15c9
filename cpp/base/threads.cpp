// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/threads.h"
#include <algorithm>
#include <cstdlib>
#include <omp.h>
#include <unistd.h>

/// OpenBLAS, where it is the BLAS.
extern "C" void openblas_set_num_threads(int number) __attribute__((weak));

namespace signorini {

void use_threads(MPI_Comm comm, std::optional<int> asked) {
  // The BLAS divides sums by its number of threads, and results must not depend on it.
  if (openblas_set_num_threads)
    openblas_set_num_threads(1);
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  int ranks = 1;
  MPI_Comm_size(machine, &ranks);
  MPI_Comm_free(&machine);
  if (asked)
    omp_set_num_threads(*asked);
  else if (!std::getenv("OMP_NUM_THREADS")) { // NOLINT(concurrency-mt-unsafe): nothing sets it
    const auto cores = static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
    // A rank that is bound to some of the cores has these to itself.
    omp_set_num_threads(std::max(1, std::min(omp_get_num_procs(), cores / ranks)));
  }
}

int threads() { return omp_get_max_threads(); }

} // namespace signorini
