// SPDX-License-Identifier: GPL-3.0-or-later
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

/// y += Σ a_i x_i, for arrays x_i of the length of y.
void add(std::span<const double> a, std::span<const float* const> x, std::span<double> y);

/// x_i·y (arrays), for arrays x_i of the length of y.
void dots(std::span<const float* const> x, std::span<const double> y, std::span<double> products);

/// C = A B, for A (m × n), B (n × k) and C, column by column; m·n within 32 bits. Not within a parallel
/// region: OpenBLAS built for one thread, as Debian's libopenblas0-serial, mixes up products at the same
/// time.
void multiply(std::span<const double> A, std::span<const double> B, std::span<double> C, std::size_t n);

} // namespace signorini
