#pragma once
#include "adjoint/enriched_body.h"
#include "forward/step.h"

namespace signorini::adjoint {

/// The duals of a run at step k and after it, for k from N down: of nodal forces p_k, and ω_k, by which M ω_k
/// is the derivative by v_k of what is left of J after t_k:
///     ω_N = 0,   ω_{k−1} = τ p_k − ω_k,   in contact-stabilized stepping + τ (Π_k − 1)(p_k − 2/τ ω_k)
class Duals {
public:
  explicit Duals(const forward::Stepper& stepper);

  /// To p_k and ω_k. `later` is the contact of step k + 1, null at N. Collective.
  void move(Vec p, const contact::ContactSets* later);

  petsc::Vector p, p_later, velocity, velocity_later; ///< p_k, p_{k+1}, ω_k, ω_{k+1}

private:
  const forward::Stepper& stepper_;
  petsc::Vector work_;
};

/// What the adjoint states of the enriched body have of bubbles, from the residual that the run's duals leave
/// there: between steps k and k + 1
///     ρ_k = ∂J/∂y_k + M ((3 ω_k − ω_{k+1})/τ − p_k) + τ/2 B (p_{k+1} − p_k) − τ²/4 A (p_k + p_{k+1})
/// which is zero on V where nothing is in contact, must be taken up by bubbles b: (τ²/2 A + τ/2 B) b_k = ρ_k
/// + τ/2 B b_{k+1}. Their inertia is left out; they are stiffer by far than the waves that the mesh can
/// carry. By conjugate gradients, in a few iterations on any mesh, since neighbouring bubbles alone feel each
/// other (hierarchical error estimate, Bank and Smith 1993).
class DualBubbles {
public:
  /// `derivative` is ∂J/∂y_k on the enriched body. Collective. The references must outlive
  /// this object.
  DualBubbles(const EnrichedBody& body, const forward::DualAtStep& derivative, forward::Scheme scheme);

  /// b_k on the active set of step k, from N − 1 down. Valid until the next call. Collective. Throws
  /// SolverFailure.
  Vec next(int k, const Duals& duals, const contact::ActiveSet& active);

  /// The last one; zero before the first.
  [[nodiscard]] Vec last() const { return b_; }

private:
  void residual(int k, const Duals& duals);
  void add(Mat matrix, double factor);
  /// out = (τ²/2 A + τ/2 B) x among bubbles
  void apply(Vec x, const contact::ActiveSet& active, Vec out);
  /// z of the residual left, by the diagonal; returns their product.
  double precondition(const contact::ActiveSet& active);

  const EnrichedBody& body_;
  const forward::DualAtStep& derivative_;
  forward::Scheme scheme_;
  petsc::Vector coarse_, b_, left_, z_, direction_, image_, work_, diagonal_;
};

} // namespace signorini::adjoint
