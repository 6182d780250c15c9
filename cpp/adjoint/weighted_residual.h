#pragma once
#include "adjoint/enriched_body.h"
#include "forward/trajectory.h"
#include <cmath>
#include <optional>

namespace signorini::adjoint {

/// What errors cost J: J(exact) − J(computed), to first order, by where they come from.
struct ErrorParts {
  std::optional<double>
      space; ///< of the mesh's elements and the interpolated loads, not of its boundary; absent for degree 2
  double time = 0;
  double initial = 0; ///< of the initial data's interpolation; zero for degree 2, like the next
  double desired = 0; ///< of the desired displacement's interpolation

  /// The estimate: errors of opposite sign cancel, in it as in J.
  [[nodiscard]] double sum() const { return space.value_or(0) + time + initial + desired; }
  /// What to trust in where the error is to be small: no part is made up for by another, which it is only by
  /// chance.
  [[nodiscard]] double sum_of_moduli() const {
    return std::abs(space.value_or(0)) + std::abs(time) + std::abs(initial) + std::abs(desired);
  }
};

/// A motion of a run whose error counts, and what it counts for.
struct Weighted {
  const forward::Trajectory& motion;         ///< with velocities
  const forward::ForceAtStep& load; ///< that acted on it
  const forward::DualAtStep& derivative; ///< ∂J/∂y_k
  /// The same on the enriched body; null without a space part.
  const forward::ForceAtStep* enriched_load;
  const forward::DualAtStep* enriched_derivative;
};

/// The adjoint-weighted residual of a computed motion (Becker and Rannacher 2001), active sets frozen, by one
/// backward sweep.
///
/// As a motion of the enriched body, the run misses the steps' equations by a residual r_k and starts from
/// other initial data, by δy_0 and δv_0. To first order that changes J by the product with its derivatives,
/// the adjoint states p_k⁺ and ω_k⁺ of that body, which are those of the run and bubbles b (dual_bubbles.h).
/// Its own p_k alone weigh nothing in r_k but the interpolation of loads and mass that massless contact has
/// moved.
///
/// Space: with a = (v_k − v_{k−1})/τ, w = (y_k − y_{k−1})/τ,
///     Σ_k τ²/2 p_k⁺·r_k,   r_k = f_k + s W u_k − M a − B w − A (y_{k−1} + y_k)/2
/// Initial data: what depends on them in the first step's right-hand side, and in v_1,
///     δv_0·M ω_0⁺ + δy_0·((τ/2 B − τ²/4 A) p_1⁺ + M (ω_0 − ω_1)/τ)
/// but for what J takes of y_0 itself.
/// Time: y is taken as piecewise quadratic, with the run's v piecewise linear, and π = τ/2 p as the dual of a
/// force per time; what is left of the equation of motion within the steps weighs
///     −τ²/12 ∫ π'·(2 A v + B v') dt + τ²/24 ∫ π'·f' dt − τ²/12 π(0)·A v_0 − τ²/24 π(0)·f'(0)
///
/// `enriched` is null without a space part. Collective. Throws SolverFailure.
ErrorParts weighted_residual(const forward::Stepper& stepper, const EnrichedBody* enriched,
                             const Weighted& run);

} // namespace signorini::adjoint
