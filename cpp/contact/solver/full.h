// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/lcp/complementarity.h"
#include "contact/lcp/snes_vi.h"
#include "contact/pairs.h"
#include "contact/solver/contact_step_solver.h"

namespace signorini::contact {

/// Solves the step's VI in all unknowns by PETSc's VI solver, in nodal frames in which ν is a coordinate
/// direction, so that the constraint is a simple bound (docs/method.md section 5). The reference for
/// CondensedSolver. Allows one candidate per node.
class FullSolver final : public ContactStepSolver {
public:
  /// Sets up the VI of D, which may be changed afterwards. Collective. `pairs` must outlive this object.
  /// PETSc options with the prefix `-full_vi_` are honoured. Throws UserError if a node has several
  /// candidates.
  FullSolver(const ContactPairs& pairs, Mat D);

  /// Sets the solver of linearised and transposed steps.
  void linearise_by(std::unique_ptr<const ContactStepSolver> solver) { linearised_ = std::move(solver); }

  [[nodiscard]] Workspace workspace() const override;
  void solve(const ContactProblem& step, Workspace& work) const override;
  /// Solves a linearised step; this and solve_transposed() require linearise_by() before.
  void solve_linearised(const LinearisedContact& step, Workspace& work) const override {
    linearised_->solve_linearised(step, work);
  }
  void solve_transposed(const LinearisedContact& step, Workspace& work) const override {
    linearised_->solve_transposed(step, work);
  }
  /// Memory of the solver of linearised steps, bytes; that of PETSc's VI solver is not known.
  [[nodiscard]] double bytes() const override { return linearised_ ? linearised_->bytes() : 0; }

private:
  /// Local number in z_ of a candidate's bounded coordinate if this rank owns it, else −1.
  [[nodiscard]] PetscInt coordinate(std::size_t i) const;

  const ContactPairs& pairs_;
  Complementarity complementarity_;
  double length_unit_, force_unit_; ///< units of the VI: negligible gap (m); that times D's largest diagonal
  std::vector<int> axis_;           ///< component that each candidate's force direction replaces (m)
  std::vector<double> length_;      ///< length of each force direction; 1 unless components are clamped (m)
  petsc::Matrix Q_;        ///< nodal frames: column axis_ of a candidate's block is its force direction
  petsc::Matrix D_;        ///< QᵀDQ in the units of the VI
  petsc::Vector diagonal_; ///< diagonal of D if components of candidates' nodes are clamped, else null
  petsc::Vector z_, r_;
  std::optional<SnesVi> vi_;
  std::unique_ptr<const ContactStepSolver> linearised_;
};

} // namespace signorini::contact
