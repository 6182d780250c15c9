#pragma once
#include <span>
#include <vector>

namespace signorini {

/// The factor of a symmetric positive definite K (n × n), in place, by LAPACK's Cholesky: 0, or the number of the pivot that is
/// not positive.
int factorise_dense(std::span<double> K, std::size_t n);

/// x of K x = b by that factor, for each of the columns of b (n each), in place.
void solve_factorised(std::span<const double> factor, std::size_t n, std::span<double> b);

/// K⁻¹ by that factor, in place, both triangles. The number of a pivot that is zero, 0 if none is.
int invert_factorised(std::span<double> factor, std::size_t n);

/// x of K x = b for a symmetric positive definite K (n × n), for each of the columns of b (n each), in place. Throws SolverFailure
/// if K is not positive definite.
void solve_dense(std::vector<double> K, std::span<double> b);

} // namespace signorini
