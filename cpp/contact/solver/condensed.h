// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/lcp/complementarity.h"
#include "contact/solver/law_solver.h"
#include <functional>

namespace signorini::contact {

/// Computes out ← r − D y at unclamped dofs, and zero at clamped ones. Collective.
using Residual = std::function<void(Vec y, Vec r, Vec out)>;

/// Solves the variational inequality (VI) of a step, condensed to the m candidates (docs/method.md section
/// 5): 0 ≤ λ ⟂ g = g⁰ + Sλ ≥ 0 with the predicted gaps g⁰ = g(D⁻¹r); then y = D⁻¹(r − Hλ). If no predicted
/// gap is negative, no VI is solved.
///
/// Otherwise primal-dual steps search for the active set. They start from the set of the previous step, since
/// usually few candidates change. If they do not settle soon, PETSc's VI solver finds the set from the VI in
/// the gaps, 0 ≤ g ⟂ S⁻¹(g − g⁰) ≥ 0: unlike S, S⁻¹ is close to an M-matrix, for which reduced-space Newton
/// steps do not cycle. A dual active-set method replaces PETSc's solver if candidates are linearly dependent,
/// so that S is singular; it is also the last resort if both other methods fail. PETSc's solver and the dual
/// method run on rank 0 alone, because LAPACK's rounding may differ between ranks. If columns of S are
/// computed on demand, block pivoting replaces all of these methods.
///
/// Laws with a non-symmetric system (Law::symmetric()) are solved by LawSolver. For symmetric laws, the gaps
/// on the active set have a rounding error relative to the motion without contact. In very long steps this
/// motion is so much longer than the body that the error exceeds the accepted penetration; the solution is
/// then refined from its residual.
class CondensedSolver final : public ContactStepSolver {
public:
  /// `condensation`: condensation of the step operator D, whose solves have the relative error `tolerance`;
  /// `diagonal`: that of D; `diameter`: that of the body, m. If `residual` is empty, solutions are not
  /// refined. `rows` must outlive this object. PETSc options with the prefix `-condensed_vi_` are honoured.
  /// Collective.
  CondensedSolver(const ConstraintRows& rows, double diameter, Vec diagonal,
                  std::unique_ptr<const Condensation> condensation, Residual residual, double tolerance = 0);

  [[nodiscard]] Workspace workspace() const override;
  void solve(const ContactProblem& step, Workspace& work) const override;
  void solve_linearised(const LinearisedContact& step, Workspace& work) const override {
    delassus_.solve_linearised(step, work);
  }
  void solve_transposed(const LinearisedContact& step, Workspace& work) const override {
    delassus_.solve_transposed(step, work);
  }
  void solve_one_sided(const LinearisedContact& step, ContactLinearisation& contact,
                       Workspace& work) const override;
  [[nodiscard]] double bytes() const override { return delassus_.bytes(); }

private:
  /// Computes λ for zero gaps on work.set and zero forces elsewhere, and the gaps g⁰ + Sλ of all candidates.
  /// Collective.
  void solve_on_set(ContactState& state, Workspace& work) const;
  /// Takes primal-dual steps until the state is complementary up to rounding and no penetration exceeds
  /// `negligible` (m). Takes at most `most` steps. Collective.
  void settle(ContactState& state, std::span<const double> psi, double negligible, int most,
              Workspace& work) const;
  /// Whether the state is complementary up to rounding errors of the motion in this step.
  [[nodiscard]] bool is_complementary(const ContactState& state, std::span<const double> psi,
                                      std::span<const double> gap0) const;
  /// Determines work.set by PETSc's VI solver, starting from the gaps of `state`. If the solver fails,
  /// work.set becomes the set of candidates with negative predicted gaps. Rank 0 only.
  void find_set(ContactState& state, Workspace& work) const;
  /// Determines work.set by the dual active-set method, which starts without contact and terminates for every
  /// S. Rank 0 only. Throws SolverFailure if the gaps cannot all be made nonnegative.
  void find_independent_set(ContactState& state, Workspace& work) const;
  /// Determines work.set by find_set() or, if S is singular or too large for PETSc, by
  /// find_independent_set(). Rank 0 only.
  void search(ContactState& state, Workspace& work) const;
  /// Computes λ and gaps by block pivoting, whose first steps are whole primal-dual steps. Collective.
  void pivot(ContactState& state, std::span<const double> psi, Workspace& work) const;
  /// Computes λ, gaps and the active set for symmetric laws; some predicted gap must be negative. Collective.
  void solve_by_sets(const ContactProblem& step, Workspace& work) const;
  /// Computes λ, gaps and y for laws that are not symmetric; some predicted gap must be negative. Returns the
  /// residual of the laws up to which they are solved, m. Collective.
  [[nodiscard]] double solve_by_laws(const ContactProblem& step, Workspace& work) const;
  /// Rounding error of predicted gaps, estimated from the size of the motion in this step, m.
  [[nodiscard]] double rounding(std::span<const double> psi, std::span<const double> gap0) const;
  /// Residual of the laws that rounding errors may cause, m.
  [[nodiscard]] double negligible(std::span<const double> psi, std::span<const double> gap0) const;
  /// Refines the solution iteratively from its residual, with zero gaps on work.set. The error becomes
  /// rounding relative to the solution with contact, rather than to the longer motion without contact.
  /// Updates work.set by primal-dual steps from the refined solution. Collective.
  void refine(Vec r, std::span<const double> psi, ContactState& state, Vec y, Workspace& work) const;
  /// Broadcasts work.set, λ and the number of steps from rank 0, which has determined them. Collective.
  void broadcast_decision(ContactState& state, Workspace& work) const;
  [[nodiscard]] std::unique_ptr<CondensedVi> make_vi() const;

  const ConstraintRows& rows_;
  DelassusOperator delassus_;
  Complementarity complementarity_;
  LawSolver laws_{rows_, delassus_, complementarity_.compliances()};
  Residual residual_;
  double tolerance_;
  double length_unit_; ///< unit of gaps in PETSc's VI: the accepted penetration, m
};

} // namespace signorini::contact
