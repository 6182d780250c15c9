// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <span>
#include <vector>

namespace signorini {

/// Factorises a symmetric positive definite K (n × n) in place by LAPACK's Cholesky (lower triangle). Returns
/// 0, or the number, from 1, of the first pivot that is not positive.
int factorise_dense(std::span<double> K, std::size_t n);

/// Solves K x = b in place with that factor, for each column of b (n × columns, column by column).
void solve_factorised(std::span<const double> factor, std::size_t n, std::span<double> b);

/// Replaces that factor by K⁻¹, both triangles. Returns 0, or the number, from 1, of a pivot that is zero.
int invert_factorised(std::span<double> factor, std::size_t n);

/// Eigenvalues of a symmetric K (n × n), ascending, by LAPACK; K becomes the eigenvectors, one after another.
/// Throws SolverFailure.
std::vector<double> symmetric_eigenvalues(std::span<double> K, std::size_t n);

/// Solves K x = b in place for a symmetric positive definite K (n × n), for each column of b (n × columns,
/// column by column). Returns false, with b as it was, if K is not positive definite.
[[nodiscard]] bool solve_dense(std::vector<double> K, std::span<double> b);

/// Solves K x = b, or Kᵀ x = b, in place for a general K (n × n, column by column), which becomes its factors
/// LU. Returns 0, or the number, from 1, of the first pivot that is zero.
[[nodiscard]] int solve_general(std::span<double> K, std::size_t n, bool transposed, std::span<double> b);

} // namespace signorini
