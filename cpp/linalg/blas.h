#pragma once
#include <span>

namespace signorini {

/// BLAS on arrays of this rank, also beyond its 32-bit counts; x and y of equal length. Not collective.

/// y += a x.
void axpy(double a, std::span<const double> x, std::span<double> y);

/// x *= a.
void scale(double a, std::span<double> x);

/// x·y.
double dot(std::span<const double> x, std::span<const double> y);

} // namespace signorini
