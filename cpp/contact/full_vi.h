#pragma once
#include "contact/vi_solver.h"

namespace signorini::contact {

/// The step's VI posed on all unknowns: nodal frames rotated so that ν is a coordinate direction, where the constraint
/// is a simple bound, and PETSc's VI solver on the whole. The reference for CondensedVi.
class FullVi final : public ViSolver {
public:
  /// Collective. The arguments must outlive this object. PETSc options with the prefix `-full_vi_` are honoured.
  FullVi(const Constraints& constraints, Mat D, const Complementarity& complementarity);

  ContactState solve(Vec r, const ContactState& previous, Vec y) const override;

private:
  const Constraints& constraints_;
  const Complementarity& complementarity_;
  double force_unit_ = 1, length_unit_ = 1;
  petsc::NonlinearSolver snes_;
  petsc::Matrix Q_; ///< nodal frames: columns of a candidate's block are ν and its complement
  petsc::Matrix D_; ///< QᵀDQ in units in which its largest diagonal entry is one
  petsc::Vector z_, start_, residual_, r_, lower_, upper_;
};

} // namespace signorini::contact
