// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/coordinates.h"
#include <optional>
#include <span>

namespace signorini::optimize {

/// The linear function d ↦ g·d − e, d from the current point, of a gradient of J gathered near that point.
struct Cut {
  Coordinates gathered;           ///< the gradient where it was evaluated
  Coordinates here;               ///< g: the same moved to the current point by Hessian products
  Coordinates offset;             ///< from the current point to where it was evaluated
  double linearisation_error = 0; ///< e ≥ 0: how far the cut lies below J at the current point
};

/// A convex combination of gradients of cuts.
struct Combination {
  double length = 0;
  std::vector<double> weights; ///< of all cuts, Σ = 1
};

/// The minimum-norm subgradient: the shortest convex combination of the gradients gathered within the ball of
/// this radius around the current point, whose own gradient, that of the first cut, is always among them
/// (Goldstein 1977). Throws SolverFailure if there is none, of gradients that are not finite.
[[nodiscard]] Combination minimum_norm_subgradient(std::span<const Cut> cuts, double radius);

/// max_i (g_i·d − e_i).
[[nodiscard]] double highest(std::span<const Cut> cuts, const Coordinates& d);

/// A direction from the current point, with what a model of J foretells of it.
struct Direction {
  Coordinates d, Hd;       ///< H d is empty as long as no Hessian product was made
  Combination subgradient; ///< of the model at d; without its curvature
  double predicted = 0;    ///< decrease of J
};

/// The minimiser d of max_i (g_i·d − e_i) + ½ d·Bd, by its dual, a quadratic program over the simplex; none
/// if B (n × n) is not positive definite or the program has no solution.
[[nodiscard]] std::optional<Direction> model_minimiser(std::span<const Cut> cuts, std::vector<double> B,
                                                       std::size_t n);

/// An offset of this length along which cut i rises above the others of `carrying`; none if there are no
/// others or their edges with i are dependent.
[[nodiscard]] std::optional<Coordinates> offset_above(std::span<const Cut> cuts, std::size_t i,
                                                      std::span<const std::size_t> carrying, double length);

} // namespace signorini::optimize
