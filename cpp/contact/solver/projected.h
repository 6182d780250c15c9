// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/lcp/complementarity.h"
#include "contact/solver/contact_step_solver.h"
#include "linalg/conjugate_gradients.h"

namespace signorini::contact {

/// Solves contact steps without a factor of D and without S (docs/method.md section 5), by conjugate
/// gradients on the motions that keep the gaps of a set closed. Primal-dual steps update the set. The set is
/// also checked during a solve, which ends early if the set would change.
class ProjectedSolver final : public ContactStepSolver {
public:
  /// `diameter`: that of the body, m; `matrix`: the matrix D. The arguments must outlive this object.
  /// Collective.
  ProjectedSolver(const ConstraintRows& rows, double diameter, const ConjugateGradients& D, Mat matrix);

  [[nodiscard]] Workspace workspace() const override { return Workspace(rows_.count()); }
  void solve(const ContactProblem& step, Workspace& work) const override;
  void solve_linearised(const LinearisedContact& step, Workspace& work) const override;
  void solve_transposed(const LinearisedContact& step, Workspace& work) const override {
    solve_linearised(step, work);
  }
  /// Not for this solver, whose laws are symmetric. Throws std::logic_error.
  void solve_one_sided(const LinearisedContact& step, ContactLinearisation& contact,
                       Workspace& work) const override;
  [[nodiscard]] double bytes() const override { return 0; }

private:
  /// Computes λ and g for a motion y that keeps the gaps of work.set closed, and the next set, work.next.
  /// Collective.
  void evaluate(Vec r, std::span<const double> psi, Vec y, ContactState& state, Workspace& work) const;

  const ConstraintRows& rows_;
  const ConjugateGradients& D_;
  Mat matrix_;
  Complementarity complementarity_;
  const std::vector<double> zero_; ///< zeros, one for each row
  double gap_tolerance_;           ///< accepted penetration, m
  petsc::Vector residual_;
  petsc::Vector diagonal_; ///< diagonal of D if a constrained dof is clamped, else null
};

} // namespace signorini::contact
