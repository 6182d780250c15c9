// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "adjoint/enriched_body.h"
#include "trajectory/trajectory.h"
#include <cmath>
#include <optional>

namespace signorini::adjoint {

/// Estimate of the error J(exact) − J(computed), to first order, by source.
struct ErrorParts {
  std::optional<double> space; ///< error of elements and interpolated loads, but not of the boundary's
                               ///< approximation by the mesh; absent for degree 2
  double time = 0;             ///< error of the time steps
  double initial = 0;          ///< error of the initial data's interpolation; zero for degree 2
  double desired = 0;          ///< error of the desired displacement's interpolation; zero for degree 2

  /// Returns the estimated error. Errors of opposite sign cancel, as they do in J.
  [[nodiscard]] double sum() const { return space.value_or(0) + time + initial + desired; }
  /// Returns the sum of the moduli of the parts. It is to be compared with a tolerance, since cancellation
  /// between parts is accidental.
  [[nodiscard]] double sum_of_moduli() const {
    return std::abs(space.value_or(0)) + std::abs(time) + std::abs(initial) + std::abs(desired);
  }
};

/// Motion whose error is estimated, its load, and the derivative of J that weights the error.
struct Weighted {
  const trajectory::Trajectory& motion; ///< motion that stores velocities
  const step::ForceAtStep& load;        ///< load that acted on it
  const step::DualAtStep& derivative;   ///< ∂J/∂y_k
  /// Load on the enriched body; null if no space part is wanted.
  const step::ForceAtStep* enriched_load;
  /// ∂J/∂y_k on the enriched body; null if no space part is wanted.
  const step::DualAtStep* enriched_derivative;
};

/// Estimates the error of J by the adjoint-weighted residual of a computed motion (Becker and Rannacher 2001;
/// docs/method.md section 7), with frozen active sets and one backward sweep.
///
/// Taken as a motion of the enriched body, the computed motion violates the step equations by a residual r_k,
/// and its initial data are off by δy_0 and δv_0. To first order J changes by the products of these with the
/// enriched body's adjoint states p_k⁺ and ω_k⁺. The latter are the run's adjoint states plus bubbles β
/// (enriched_body.h). Since the run satisfies its own step equations, the product of r_k with the run's p_k
/// contains only the interpolation errors of loads and the redistribution of mass by massless contact.
///
/// Space: with a = (v_k − v_{k−1})/τ_k, w = (y_k − y_{k−1})/τ_k,
///     Σ_k τ_k²/2 p_k·r_k + Σ_k β_k·(R_{k−1} + 2 R_k + R_{k+1})/4,   R_k = (τ_k r_k + τ_{k+1} r_{k+1})/2,
///     r_k = f_k + s W u_k − M a − B w − A (y_{k−1} + y_k)/2
/// where the mean over three times removes the part that alternates from step to step in contact.
/// Initial data: they enter the first step's right-hand side and v_1, which contributes
///     δv_0·M ω_0⁺ + δy_0·((τ_1/2 B − τ_1²/4 A) p_1⁺ + M (ω_0 − ω_1)/τ_1)
/// The direct dependence of J on y_0 is not included.
/// Time: y is taken as piecewise quadratic, with the run's v piecewise linear. π, the dual of a force per
/// time, is τ_k/2 p_k in the middle of step k and linear between the middles. Loads act by their means over
/// the steps. The residual of the equation of motion within the steps contributes
///     Σ_k −τ_k²/12 ∫ π'·(2 A v + B v' − f') dt + [τ_k²/12 π·A v] over step k
/// In the sum over k, the brackets of neighbouring steps cancel, except for the value at t = 0 and, at times
/// t_k where the step length changes, (τ_k² − τ_{k+1}²)/12 π·A v.
///
/// `enriched`: null if only the time part is wanted. `by_nodes`: if given, a vector of the enriched body to
/// which the bubbles' share of the space part is added node by node. ErrorParts::desired stays zero.
/// Collective. Throws SolverFailure.
ErrorParts weighted_residual(const step::Stepper& stepper, const EnrichedBody* enriched, const Weighted& run,
                             Vec by_nodes = nullptr);

} // namespace signorini::adjoint
