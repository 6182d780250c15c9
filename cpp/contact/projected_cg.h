#pragma once
#include "contact/condensation.h"
#include "contact/vi_solver.h"

namespace signorini::contact {

/// Contact without a factor of D and without S: conjugate gradients on the motions that keep a set of gaps
/// closed, the set updated by primal-dual steps. It is judged on the way to the solution, since the sooner it
/// changes, the less is lost.
class ProjectedCg final : public ViSolver, public SlidingSolver {
public:
  /// `matrix` is D. Collective. The arguments must outlive this object.
  ProjectedCg(const Constraints& constraints, const ConjugateGradients& D, Mat matrix,
              const Complementarity& complementarity);

  void solve(Vec r, std::span<const double> psi, const ContactSets& previous, ContactState& state,
             Vec y) const override;
  void solve_sliding(Vec r, const ActiveSet& set, Vec p) const override;

private:
  /// λ and g of a motion that keeps set_ closed, and the set that they call for. Collective.
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
