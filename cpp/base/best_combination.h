#pragma once
#include <span>
#include <vector>

namespace signorini {

/// Weights of the shortest convex combination of vectors, given their products with each other G (n × n), or
/// where each also has a price e, of the best: argmin ½ w·Gw + e·w over w ≥ 0, Σ w = 1. Found by PETSc's TAO,
/// on this rank alone; where rounding keeps TAO from its tolerance the weights are those that it came to,
/// which are convex all the same. Throws SolverFailure if an input is not finite.
[[nodiscard]] std::vector<double> best_combination(std::span<const double> products,
                                                   std::span<const double> prices);

} // namespace signorini
