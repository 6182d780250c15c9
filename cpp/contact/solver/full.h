// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/lcp/complementarity.h"
#include "contact/lcp/snes_vi.h"
#include "contact/pairs.h"
#include "contact/solver/contact_step_solver.h"

namespace signorini::contact {

/// Solves the variational inequality (VI) of a step in all unknowns by PETSc's VI solver. It uses nodal
/// frames in which ν is a coordinate direction, so that the constraints are simple bounds (docs/method.md
/// section 5). This solver is the reference for CondensedSolver; it supports only one candidate per node.
class FullSolver final : public ContactStepSolver {
public:
  /// Sets up the VI. `D` is copied and may be changed afterwards; `pairs` must outlive this object. PETSc
  /// options with the prefix `-full_vi_` are honoured. Collective. Throws UserError if a node has several
  /// candidates.
  FullSolver(const ContactPairs& pairs, Mat D);

  /// Sets the solver for linearised, one-sided and transposed steps; call this before the first of them.
  void linearise_by(std::unique_ptr<const ContactStepSolver> solver) { linearised_ = std::move(solver); }

  [[nodiscard]] Workspace workspace() const override;
  void solve(const ContactProblem& step, Workspace& work) const override;
  void solve_one_sided(const LinearisedContact& step, ContactLinearisation& contact,
                       Workspace& work) const override {
    linearised_->solve_one_sided(step, contact, work);
  }
  void solve_linearised(const LinearisedContact& step, Workspace& work) const override {
    linearised_->solve_linearised(step, work);
  }
  void solve_transposed(const LinearisedContact& step, Workspace& work) const override {
    linearised_->solve_transposed(step, work);
  }
  /// Memory of the solver of linearised steps, bytes; PETSc does not report the memory of its VI solver.
  [[nodiscard]] double bytes() const override { return linearised_ ? linearised_->bytes() : 0; }

private:
  /// Local position in z_ of the bounded coordinate of candidate i; −1 if another rank owns it.
  [[nodiscard]] PetscInt coordinate(std::size_t i) const;

  const ContactPairs& pairs_;
  Complementarity complementarity_;
  double length_unit_, force_unit_; ///< units of the VI: gap_tolerance(), m; this times the largest (QᵀDQ)_jj
  std::vector<int> axis_;           ///< for each candidate, the component that its force direction replaces
  std::vector<double> length_;      ///< for each candidate, the norm of its force direction; 1 if unclamped
  petsc::Matrix Q_;        ///< nodal frames: column axis_ of a candidate's block is its force direction
  petsc::Matrix D_;        ///< QᵀDQ in the units of the VI
  petsc::Vector diagonal_; ///< diagonal of D if a constrained dof is clamped, else null
  petsc::Vector z_, r_;
  std::optional<SnesVi> vi_;
  std::unique_ptr<const ContactStepSolver> linearised_;
};

} // namespace signorini::contact
