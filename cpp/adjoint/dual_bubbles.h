// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "adjoint/enriched_body.h"
#include "step/step.h"

namespace signorini::adjoint {

/// The adjoint states p_k of a run and ω_k, at steps k and k + 1, for k from N down; M ω_k is the derivative
/// by v_k of the part of J after t_k (docs/method.md section 4):
///     ω_N = 0,   ω_{k−1} = τ_k p_k − ω_k;   contact-stabilized steps add τ_k (Π_k − 1)(p_k − 2/τ_k ω_k)
class Duals {
public:
  /// `grid`: of the motion. `stepper` must outlive this object. Collective.
  Duals(const step::Stepper& stepper, const step::TimeGrid& grid);

  /// Moves from step k + 1 to k, with p_k in `p`. `later` is the contact of step k + 1, null at N.
  /// Collective.
  void move(int k, Vec p, const contact::ContactLinearisation* later);

  petsc::Vector p, p_later, velocity, velocity_later; ///< p_k, p_{k+1}, ω_k, ω_{k+1}

private:
  const step::Stepper& stepper_;
  step::TimeGrid grid_;
  petsc::Vector work_;
  std::optional<step::PredictorProjection::Workspace> predictor_;
};

/// The bubble part of the enriched body's adjoint states: π = τ_k/2 p_k is the dual of a force per time, with
/// bubbles β_k at t_k. The run's duals leave there, between steps k and k + 1, the residual
///     ρ_k = ∂J/∂y_k + M ((1/τ_{k+1} + 2/τ_k) ω_k − 1/τ_{k+1} ω_{k+1} − p_k) + B (τ_{k+1}/2 p_{k+1} − τ_k/2
///     p_k)
///           − A (τ_k²/4 p_k + τ_{k+1}²/4 p_{k+1})
/// which is zero on V where nothing is in contact. The bubbles solve
///     ((τ_k + τ_{k+1})/2 A + B) β_k = ρ_k + B β_{k+1}
/// without inertia: they are far stiffer than the waves that the mesh can resolve. Conjugate gradients,
/// preconditioned by the diagonal, take a few iterations on any mesh, since only neighbouring bubbles are
/// coupled (hierarchical error estimate, Bank and Smith 1993; docs/method.md section 7).
class DualBubbles {
public:
  /// `derivative` is ∂J/∂y_k on the enriched body. Collective. The references must outlive
  /// this object.
  DualBubbles(const EnrichedBody& body, const step::DualAtStep& derivative, const step::TimeGrid& grid);

  /// β_k on the active set of step k, from N − 1 down. Valid until the next call. Collective. Throws
  /// SolverFailure.
  Vec next(int k, const Duals& duals, const contact::ActiveSet& active);

  /// β_k of the last call of next(); zero before the first.
  [[nodiscard]] Vec last() const { return b_; }

private:
  void residual(int k, const Duals& duals);
  void add(Mat matrix, double factor);
  /// Takes the mean length of the steps that meet.
  void set_length(double mean);
  /// out = (τ A + B) x, τ the mean length, restricted to the bubbles that are free to move.
  void apply(Vec x, const contact::ActiveSet& active, Vec out);
  /// z = residual / diagonal, restricted likewise; returns z · residual.
  double precondition(const contact::ActiveSet& active);

  const EnrichedBody& body_;
  const step::DualAtStep& derivative_;
  step::TimeGrid grid_;
  double mean_ = 0;
  petsc::Vector coarse_, b_, left_, z_, direction_, image_, work_, of_A_, of_B_, diagonal_;
};

} // namespace signorini::adjoint
