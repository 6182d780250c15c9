#pragma once
#include "contact/delassus_operator.h"
#include "contact/vi_solver.h"

namespace signorini::contact {

/// Contact without a factor of D and without S (docs/method.md section 5): conjugate gradients on the motions
/// that keep the gaps of a set closed, the set updated by primal-dual steps. The set is checked before a
/// solve has converged, to end it early where the set will change.
class ProjectedCg final : public ViSolver, public ActiveSetKkt {
public:
  /// `matrix` is D. Collective. The arguments must outlive this object.
  ProjectedCg(const Constraints& constraints, const ConjugateGradients& D, Mat matrix,
              const Complementarity& complementarity);

  void solve(Vec r, std::span<const double> psi, const ContactSets& previous, ContactState& state,
             Vec y) const override;
  void solve_sliding(Vec r, const ActiveSet& set, Vec p) const override;

private:
  /// Computes λ and g of a motion y that keeps the gaps of set_ closed, and the next set, next_. Collective.
  void evaluate(Vec r, std::span<const double> psi, Vec y, ContactState& state) const;

  const Constraints& constraints_;
  const ConjugateGradients& D_;
  Mat matrix_;
  const Complementarity& complementarity_;
  const std::vector<double> zero_; ///< (m)
  petsc::Vector residual_;
  petsc::Vector diagonal_; ///< of D where clamps hold components of candidates' nodes, else null
  mutable ActiveSet set_, next_, wrong_;
};

} // namespace signorini::contact
