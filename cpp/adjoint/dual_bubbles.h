#pragma once
#include "adjoint/enriched_body.h"
#include "forward/step.h"

namespace signorini::adjoint {

/// The adjoint states p_k of a run and ω_k, at steps k and k + 1, for k from N down; M ω_k is the derivative
/// by v_k of the part of J after t_k (docs/method.md section 4):
///     ω_N = 0,   ω_{k−1} = τ p_k − ω_k;   contact-stabilized steps add τ (Π_k − 1)(p_k − 2/τ ω_k)
class Duals {
public:
  /// `stepper` must outlive this object. Collective.
  explicit Duals(const forward::Stepper& stepper);

  /// Moves from step k + 1 to k, with p_k in `p`. `later` is the contact of step k + 1, null at N.
  /// Collective.
  void move(int k, Vec p, const contact::ContactSets* later);

  petsc::Vector p, p_later, velocity, velocity_later; ///< p_k, p_{k+1}, ω_k, ω_{k+1}

private:
  const forward::Stepper& stepper_;
  petsc::Vector work_;
  std::optional<forward::Predictor::Workspace> predictor_;
};

/// The bubble part b_k of the enriched body's adjoint states. The run's duals leave there, between steps k
/// and k + 1, the residual
///     ρ_k = ∂J/∂y_k + M ((3 ω_k − ω_{k+1})/τ − p_k) + τ/2 B (p_{k+1} − p_k) − τ²/4 A (p_k + p_{k+1})
/// which is zero on V where nothing is in contact. The bubbles solve
///     (τ²/2 A + τ/2 B) b_k = ρ_k + τ/2 B b_{k+1}
/// without inertia: they are far stiffer than the waves that the mesh can resolve. Conjugate gradients,
/// preconditioned by the diagonal, take a few iterations on any mesh, since only neighbouring bubbles are
/// coupled (hierarchical error estimate, Bank and Smith 1993; docs/method.md section 7).
class DualBubbles {
public:
  /// `derivative` is ∂J/∂y_k on the enriched body. Collective. The references must outlive
  /// this object.
  DualBubbles(const EnrichedBody& body, const forward::DualAtStep& derivative, forward::Scheme scheme);

  /// b_k on the active set of step k, from N − 1 down. Valid until the next call. Collective. Throws
  /// SolverFailure.
  Vec next(int k, const Duals& duals, const contact::ActiveSet& active);

  /// b_k of the last call of next(); zero before the first.
  [[nodiscard]] Vec last() const { return b_; }

private:
  void residual(int k, const Duals& duals);
  void add(Mat matrix, double factor);
  /// out = (τ²/2 A + τ/2 B) x, restricted to the bubbles that are free to move.
  void apply(Vec x, const contact::ActiveSet& active, Vec out);
  /// z = residual / diagonal, restricted likewise; returns z · residual.
  double precondition(const contact::ActiveSet& active);

  const EnrichedBody& body_;
  const forward::DualAtStep& derivative_;
  forward::Scheme scheme_;
  petsc::Vector coarse_, b_, left_, z_, direction_, image_, work_, diagonal_;
};

} // namespace signorini::adjoint
