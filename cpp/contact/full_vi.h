#pragma once
#include "contact/linear_vi.h"
#include "contact/vi_solver.h"
#include <optional>

namespace signorini::contact {

/// The step's VI posed on all unknowns: nodal frames rotated so that ν is a coordinate direction, where the
/// constraint is a simple bound, and PETSc's VI solver on the whole. The reference for CondensedVi. A node
/// has one candidate.
class FullVi final : public ViSolver {
public:
  /// Collective. The arguments must outlive this object. PETSc options with the prefix `-full_vi_` are
  /// honoured. Throws UserError if a node has several candidates.
  FullVi(const Constraints& constraints, Mat D, const Complementarity& complementarity);

  void solve(Vec r, std::span<const double> psi, const ContactSets& previous, ContactState& state,
             Vec y) const override;

private:
  /// The bounded coordinate of a candidate if this rank owns it, else −1: its local number in z.
  [[nodiscard]] PetscInt coordinate(std::size_t i) const;

  const Constraints& constraints_;
  const Complementarity& complementarity_;
  double length_unit_, force_unit_; ///< of the VI: a negligible gap, and the force that makes it
  std::vector<int> axis_;           ///< component that the direction of each candidate's force takes over (m)
  std::vector<double> length_;      ///< of these directions, 1 but where a clamp holds components (m)
  petsc::Matrix Q_;        ///< nodal frames: a column of a candidate's block is the direction of its force
  petsc::Matrix D_;        ///< QᵀDQ in these units
  petsc::Vector diagonal_; ///< of D where clamps hold components of candidates' nodes, else null
  petsc::Vector z_, r_;
  std::optional<LinearVi> vi_;
};

} // namespace signorini::contact
