// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/machine.h"
#include "base/collective.h"
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <malloc.h>
#include <omp.h>
#include <string>
#include <sys/resource.h>
#include <unistd.h>

/// Present if the BLAS is OpenBLAS, else null (weak symbol).
extern "C" void openblas_set_num_threads(int number) __attribute__((weak));

namespace signorini {

void use_threads(MPI_Comm comm, std::optional<int> asked) {
  // The BLAS divides sums by its number of threads, and results must not depend on it.
  if (openblas_set_num_threads)
    openblas_set_num_threads(1);
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  const int sharing = ranks(machine);
  MPI_Comm_free(&machine);
  if (asked)
    omp_set_num_threads(*asked);
  else if (!std::getenv("OMP_NUM_THREADS")) { // NOLINT(concurrency-mt-unsafe): nothing sets it
    const auto cores = static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
    // A rank that is bound to some of the cores has these to itself.
    omp_set_num_threads(std::max(1, std::min(omp_get_num_procs(), cores / sharing)));
  }
}

int threads() { return omp_get_max_threads(); }

double processor_seconds() {
#ifdef RUSAGE_THREAD
  constexpr int here = RUSAGE_THREAD;
#else
  constexpr int here = RUSAGE_SELF;
#endif
  double seconds = 0;
  for (const int whose : {here, static_cast<int>(RUSAGE_CHILDREN)}) {
    rusage usage{};
    getrusage(whose, &usage);
    for (const timeval& part : {usage.ru_utime, usage.ru_stime})
      seconds += static_cast<double>(part.tv_sec) + 1e-6 * static_cast<double>(part.tv_usec);
  }
  return seconds;
}

double peak_memory() {
  // getrusage() would include the peak of the program that started this one, such as a notebook.
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (double kib = 0; std::sscanf(line.c_str(), "VmHWM: %lf kB", &kib) == 1)
      return 1024 * kib;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
#ifdef __APPLE__
  constexpr double unit = 1;
#else
  constexpr double unit = 1024; // KiB
#endif
  return unit * static_cast<double>(usage.ru_maxrss);
}

double resident_memory() {
  double whole = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> whole >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

void forget_peak_memory() {
#ifdef __GLIBC__
  malloc_trim(0); // freed heap memory would count as resident
#endif
  std::ofstream("/proc/self/clear_refs") << "5";
}

double machine_memory() {
  return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

} // namespace signorini
