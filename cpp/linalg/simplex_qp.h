#pragma once
#include <optional>
#include <span>
#include <vector>

namespace signorini {

/// Minimises ½ w·Gw + e·w over the unit simplex, w ≥ 0 and Σ w = 1, for a positive semidefinite G (n × n) and
/// e (n); returns w (n). With a Gram matrix G and e = 0 this is the shortest convex combination, with
/// products g_i·H⁻¹g_j of gradients and linearisation errors e the dual of the bundle model (docs/method.md
/// section 6). Solved by PETSc's TAO, then to rounding on an independent subset of the vectors with positive
/// weight; if that does not settle, the weights are TAO's. Not collective. None if n is 0, an entry is not
/// finite or no combination was found.
[[nodiscard]] std::optional<std::vector<double>> simplex_qp(std::span<const double> G,
                                                            std::span<const double> e);

} // namespace signorini
