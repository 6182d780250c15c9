#pragma once
#include <span>
#include <vector>

namespace signorini {

/// x of K x = b for a symmetric positive definite K (n × n), for each of the columns of b (n each), in place;
/// by LAPACK. Throws SolverFailure if K is not positive definite.
void solve_dense(std::vector<double> K, std::span<double> b);

} // namespace signorini
