// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cstddef>

/// Dense kernels of substitutions for several right-hand sides at once, whose values of one unknown are side
/// by side in lanes. Each value of the result is a sum in an order that depends on the block alone, so that
/// the result of a right-hand side depends neither on the others nor on its lane.
namespace signorini {

/// Numbers of lanes that the kernels are made for.
constexpr std::ptrdiff_t narrow_lanes = 8, wide_lanes = 16;

/// Rectangular block of a factor, stored column by column with the distance `stride`.
struct FactorBlock {
  const double* values; ///< first entry
  std::ptrdiff_t rows, columns, stride;
};

/// own ← T⁻¹ own for the lower triangle T of a square block. `own`: columns × lanes.
void solve_lanes(const FactorBlock& T, std::ptrdiff_t lanes, double* own);

/// own ← T⁻ᵀ own for the lower triangle T of a square block. `own`: columns × lanes.
void solve_lanes_transposed(const FactorBlock& T, std::ptrdiff_t lanes, double* own);

/// Subtracts row i of B own from row `row[i]` of `to`, or from row i if `row` is null. `own`: columns ×
/// lanes.
void subtract_lanes(const FactorBlock& B, std::ptrdiff_t lanes, const double* own, const int* row,
                    double* to);

/// own −= Bᵀ x, where row i of x is row `row[i]` of `from`, or row i if `row` is null.
void subtract_lanes_transposed(const FactorBlock& B, std::ptrdiff_t lanes, const double* from, const int* row,
                               double* own);

} // namespace signorini
