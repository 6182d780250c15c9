#include "linalg/blas.h"
#include <algorithm>
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

} // namespace signorini
