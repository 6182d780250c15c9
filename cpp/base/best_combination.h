#pragma once
#include <span>
#include <vector>

namespace signorini {

/// Weights of the shortest convex combination of vectors, given their products with each other G (n × n), or
/// where each also has a price e, of the best: argmin ½ w·Gw + e·w over w ≥ 0, Σ w = 1. Found by PETSc's TAO,
/// on this rank alone, and brought to rounding on the vectors that it uses, without those that depend on others;
/// where that does not end the weights are TAO's own, which are convex all the same. Throws SolverFailure if there are no vectors or an input is not
/// finite.
[[nodiscard]] std::vector<double> best_combination(std::span<const double> products,
                                                   std::span<const double> prices);

} // namespace signorini
