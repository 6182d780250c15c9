// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <optional>
#include <span>
#include <vector>

namespace signorini {

/// Minimises ½ w·Gw + e·w over the unit simplex, w ≥ 0 and Σ w = 1, for a positive semidefinite G (n × n) and
/// e (n); returns w (n). With a Gram matrix G and e = 0 this is the shortest convex combination. With
/// products g_i·H⁻¹g_j of gradients and linearisation errors e it is the dual of the bundle model
/// (docs/method.md section 6). Solved to rounding by the active-set method of Wolfe (1976), with prices.
/// Vectors enter one by one, and w minimises the value over affine combinations of those in use, which are
/// affinely independent. It ends after finitely many changes; if rounding prevents that, the best w found
/// counts. Not collective. None if n is 0, an entry is not finite or sums of them overflow.
[[nodiscard]] std::optional<std::vector<double>> simplex_qp(std::span<const double> G,
                                                            std::span<const double> e);

} // namespace signorini
