#pragma once
#include <span>

namespace signorini {

/// Arrays of this rank, by BLAS; of any length, though BLAS counts with 32 bits. Not collective.

/// y += a x.
void axpy(double a, std::span<const double> x, std::span<double> y);

/// x *= a.
void scale(double a, std::span<double> x);

/// x·y.
double dot(std::span<const double> x, std::span<const double> y);

} // namespace signorini
