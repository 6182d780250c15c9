#pragma once
#include "fem/operators.h"
#include "forward/step_solver.h"

namespace signorini::forward {

/// What contact-stabilized stepping (docs/method.md section 2) adds to a step: the predictor x = y_{k−1} + τ v_{k−1}
/// is moved to z, the nearest point to it in the norm of M that obeys the contact condition. z − x is called
/// the jump. A predictor that obeys it already costs a look at its gaps.
class Predictor {
public:
  /// Factorises M, which comes in `blocks` (BAIJ) too. `sliding`: linearised or transposed steps are wanted. Collective. The references must outlive
  /// this object. Throws SolverFailure.
  Predictor(petsc::Matrix blocks, Mat M, const fem::Clamped& clamped,
            const contact::Constraints& constraints, const scene::Solver& scene, bool sliding);

  /// z − x for the gaps ψ of the undeformed body (m), null if that is zero; `set` becomes Z, the candidates
  /// that z touches, and `previous` is that of the step before, from which the search starts. Valid until the next call. Collective. Throws SolverFailure.
  [[nodiscard]] Vec jump(std::span<const double> psi, Vec x, const contact::ActiveSet& previous,
                         contact::ActiveSet& set) const;

  /// Πx − x with Π the linearised projection on the set Z, null where Z is empty. Π is its own transpose in the
  /// product with M. Valid until the next call. Collective.
  [[nodiscard]] Vec linearised_jump(const contact::ActiveSet& set, Vec x) const;

  /// Memory on all ranks, bytes. Collective.
  [[nodiscard]] double bytes() const;

private:
  Mat M_;
  const fem::Clamped& clamped_;
  const contact::Constraints& constraints_;
  StepSolver solver_;
  petsc::Vector zero_, r_, jump_;
  mutable contact::ContactState before_, contact_;
  mutable std::vector<double> gap_;
};

} // namespace signorini::forward
