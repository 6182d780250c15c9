// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <optional>
#include <span>
#include <vector>

namespace signorini {

/// Minimises ½ w·Gw + e·w over the unit simplex (w ≥ 0, Σ w = 1) for a positive semidefinite G (n × n) and a
/// vector e (n). Returns w (n), or nothing if n is 0, an entry is not finite or sums overflow. Not
/// collective.
///
/// For a Gram matrix G and e = 0 this finds the shortest convex combination of vectors. With products
/// g_i·H⁻¹g_j of gradients and linearisation errors e it solves the dual of the bundle model (docs/method.md
/// section 6).
///
/// The active-set method of Wolfe (1976) solves the problem to rounding. It lets vectors enter one by one, by
/// their reduced costs, and minimises over the affine combinations of the entered vectors, which are affinely
/// independent. It ends after finitely many changes. If rounding prevents that, the best w found is returned.
[[nodiscard]] std::optional<std::vector<double>> simplex_qp(std::span<const double> G,
                                                            std::span<const double> e);

} // namespace signorini
