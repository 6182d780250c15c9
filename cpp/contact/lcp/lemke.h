// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <span>
#include <vector>

namespace signorini::contact {

/// Solves the linear complementarity problem w = M z + q, 0 ≤ w ⟂ z ≥ 0 by Lemke's method with the covering
/// vector of ones (Cottle, Pang, Stone 1992, section 4.4). `M`: n × n, row by row; its rows should be scaled
/// alike. Returns z, empty if the method ends on a ray or takes too many pivots. Not collective.
[[nodiscard]] std::vector<double> lemke(std::span<const double> M, std::span<const double> q);

} // namespace signorini::contact
