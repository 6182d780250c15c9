// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/machine_rates.h"
#include "base/collective.h"
#include "linalg/dense.h"
#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <vector>

namespace signorini {

namespace {

/// Seconds of the quickest of some repetitions: what other work on the machine adds is left out.
template <class Work>
double least_seconds(int repetitions, Work&& work) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repetitions; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return least;
}

double measure_flops() {
  constexpr std::size_t n =
      192; // about the width of the fronts in which a factor of a body in space has its work
  const std::vector<double> a(n * n, 1.0), b(n * n, 1.0);
  std::vector<double> c(n * n);
  constexpr double flops = 2.0 * n * n * n;
  return flops / least_seconds(8, [&] { multiply(a, b, c, n); });
}

double measure_bytes(double wanted) {
  constexpr double least = 1 << 20, most = 1 << 26;
  const std::vector<double> values(static_cast<std::size_t>(std::clamp(wanted, least, most)) / sizeof(double),
                                   1.0);
  volatile double kept = 0; // so that the sum is made
  const double seconds = least_seconds(3, [&] {
    double sum = 0;
#pragma omp parallel for simd reduction(+ : sum) schedule(static)
    for (std::size_t i = 0; i < values.size(); ++i)
      sum += values[i];
    kept = sum;
  });
  return static_cast<double>(values.size()) * sizeof(double) / seconds;
}

} // namespace

MachineRates measure_rates(MPI_Comm comm, double bytes) {
  const double size = ranks(comm);
  MPI_Barrier(comm); // so that ranks share memory's bandwidth as in a solve
  std::array<double, 2> rates{measure_flops(), measure_bytes(bytes / size)};
  MPI_Bcast(rates.data(), 2, MPI_DOUBLE, 0, comm);
  return {.flops = size * rates[0], .bytes = size * rates[1]};
}

} // namespace signorini
