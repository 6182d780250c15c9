// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cstddef>

/// Kernels of substitutions and products for several right-hand sides at once, whose values of one unknown
/// are side by side in lanes. Each value of the result is a sum in an order that depends on the block alone,
/// so that the result of a right-hand side depends neither on the others nor on its lane.
namespace signorini {

/// Numbers of lanes that the kernels are made for.
constexpr std::ptrdiff_t narrow_lanes = 8, wide_lanes = 16;

/// Right-hand sides side by side: `lanes` values of each unknown.
struct LaneGroup {
  double* values;
  std::ptrdiff_t lanes; ///< narrow_lanes or wide_lanes
};

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

/// Rows of blocks of a matrix. A block has size × size numbers by rows, or one number of which it is the
/// multiple of the identity.
struct BlockRows {
  const int *begin, *column;
  const double* values;
  int numbers; ///< of a block
};

/// Sets the rows [first, end) of r to those of R x + M w. `size`: of the blocks, 2 or 3.
void multiply_lanes(const BlockRows& R, const BlockRows& M, int size, int first, int end,
                    std::ptrdiff_t lanes, const double* x, const double* w, double* r);

/// Makes all kernels use vector registers of at most `limit` numbers, at least 2, even if the machine has
/// wider ones; for tests and benchmarks. Returns the width used. Bits of results depend on it.
int limit_lane_registers(int limit);

} // namespace signorini
