#pragma once
#include "contact/linear_vi.h"
#include "contact/vi_solver.h"
#include <optional>

namespace signorini::contact {

/// Solves the step's VI in all unknowns by PETSc's VI solver, in nodal frames in which ν is a coordinate
/// direction, so that the constraint is a simple bound (docs/method.md section 5). The reference for
/// CondensedVi. Allows one candidate per node.
class FullVi final : public ViSolver {
public:
  /// Collective. The arguments must outlive this object. PETSc options with the prefix `-full_vi_` are
  /// honoured. Throws UserError if a node has several candidates.
  FullVi(const Constraints& constraints, Mat D, const Complementarity& complementarity);

  void solve(Vec r, std::span<const double> psi, const ContactSets& previous, ContactState& state,
             Vec y) const override;

private:
  /// Local number in z_ of a candidate's bounded coordinate if this rank owns it, else −1.
  [[nodiscard]] PetscInt coordinate(std::size_t i) const;

  const Constraints& constraints_;
  const Complementarity& complementarity_;
  double length_unit_, force_unit_; ///< of the VI: a negligible gap (m); that times D's largest diagonal
  std::vector<int> axis_;           ///< component that each candidate's force direction replaces (m)
  std::vector<double> length_;      ///< of these directions; 1 unless clamps hold components (m)
  petsc::Matrix Q_;        ///< nodal frames: column axis_ of a candidate's block is its force direction
  petsc::Matrix D_;        ///< QᵀDQ in these units
  petsc::Vector diagonal_; ///< of D where clamps hold components of candidates' nodes, else null
  petsc::Vector z_, r_;
  std::optional<LinearVi> vi_;
};

} // namespace signorini::contact
