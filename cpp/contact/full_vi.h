#pragma once
#include "contact/linear_vi.h"
#include "contact/vi_solver.h"
#include <optional>

namespace signorini::contact {

/// The step's VI posed on all unknowns: nodal frames rotated so that ν is a coordinate direction, where the
/// constraint is a simple bound, and PETSc's VI solver on the whole. The reference for CondensedVi.
class FullVi final : public ViSolver {
public:
  /// Collective. The arguments must outlive this object. PETSc options with the prefix `-full_vi_` are
  /// honoured.
  FullVi(const Constraints& constraints, Mat D, const Complementarity& complementarity);

  void solve(Vec r, const ContactState& previous, ContactState& state, Vec y) const override;

private:
  const Constraints& constraints_;
  const Complementarity& complementarity_;
  double length_unit_, force_unit_; ///< of the VI: a negligible gap, and the force that makes it
  petsc::Matrix Q_;                 ///< nodal frames: columns of a candidate's block are ν and its complement
  petsc::Matrix D_;                 ///< QᵀDQ in these units
  petsc::Vector z_, r_;
  std::optional<LinearVi> vi_;
};

} // namespace signorini::contact
