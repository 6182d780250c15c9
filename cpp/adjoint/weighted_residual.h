// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "adjoint/enriched_body.h"
#include "trajectory/trajectory.h"
#include <cmath>
#include <optional>

namespace signorini::adjoint {

/// The error J(exact) − J(computed), to first order, by its sources.
struct ErrorParts {
  std::optional<double>
      space; ///< error of elements and interpolated loads, not of the mesh's boundary; absent for degree 2
  double time = 0;
  double initial = 0; ///< error of the initial data's interpolation; zero for degree 2, like the next
  double desired = 0; ///< error of the desired displacement's interpolation

  /// The estimate, in which errors of opposite sign cancel, as they do in J.
  [[nodiscard]] double sum() const { return space.value_or(0) + time + initial + desired; }
  /// The sum without cancellation between parts, which is accidental: the one to compare with a tolerance.
  [[nodiscard]] double sum_of_moduli() const {
    return std::abs(space.value_or(0)) + std::abs(time) + std::abs(initial) + std::abs(desired);
  }
};

/// A motion of a run, and the derivative of J that weighs its error.
struct Weighted {
  const trajectory::Trajectory& motion; ///< motion with velocities
  const step::ForceAtStep& load;        ///< load that acted on it
  const step::DualAtStep& derivative;   ///< ∂J/∂y_k
  /// Load and derivative on the enriched body; null without a space part.
  const step::ForceAtStep* enriched_load;
  const step::DualAtStep* enriched_derivative;
};

/// The adjoint-weighted residual of a computed motion (Becker and Rannacher 2001; docs/method.md section 7)
/// with frozen active sets, by one backward sweep.
///
/// The run, as a motion of the enriched body, violates the equations of the steps by a residual r_k and
/// starts from other initial data, by δy_0 and δv_0. To first order J changes by their products with its
/// derivatives, the adjoint states p_k⁺ and ω_k⁺ of that body, which are those of the run plus bubbles β
/// (enriched_body.h). The run's p_k alone weight nothing of r_k but the interpolation of loads and
/// the mass that massless contact has moved.
///
/// Space: with a = (v_k − v_{k−1})/τ_k, w = (y_k − y_{k−1})/τ_k,
///     Σ_k τ_k²/2 p_k·r_k + Σ_k β_k·(R_{k−1} + 2 R_k + R_{k+1})/4,   R_k = (τ_k r_k + τ_{k+1} r_{k+1})/2,
///     r_k = f_k + s W u_k − M a − B w − A (y_{k−1} + y_k)/2
/// where the mean over three times removes the part that alternates from step to step in contact.
/// Initial data: the terms that depend on them in the first step's right-hand side, and in v_1,
///     δv_0·M ω_0⁺ + δy_0·((τ_1/2 B − τ_1²/4 A) p_1⁺ + M (ω_0 − ω_1)/τ_1)
/// without the direct dependence of J on y_0.
/// Time: y is taken as piecewise quadratic, with the run's v piecewise linear, and π = τ_k/2 p_k in the
/// middle of step k as the dual of a force per time, linear between. Loads act by their means over the steps.
/// The residual of the equation of motion within the steps contributes
///     Σ_k −τ_k²/12 ∫ π'·(2 A v + B v' − f') dt + [τ_k²/12 π·A v] over step k
/// The brackets leave the values at 0 and, where lengths change, the difference of both τ².
///
/// `enriched` is null without a space part. The bubbles' share of that part is added node by node to
/// `by_nodes`, if given, a vector of the enriched body. ErrorParts::desired stays zero.
/// Collective. Throws SolverFailure.
ErrorParts weighted_residual(const step::Stepper& stepper, const EnrichedBody* enriched, const Weighted& run,
                             Vec by_nodes = nullptr);

} // namespace signorini::adjoint
