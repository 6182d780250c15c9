// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/delassus_operator.h"
#include "contact/lcp/complementarity.h"
#include <functional>

namespace signorini::contact {

/// Computes out ← r − D y at unclamped dofs, zero at clamped ones. Collective.
using Residual = std::function<void(Vec y, Vec r, Vec out)>;

/// Solves the step's VI condensed to the m candidates (docs/method.md section 5): with the predicted gaps g⁰
/// = g(D⁻¹r), 0 ≤ λ ⟂ g = g⁰ + Sλ ≥ 0 and y = D⁻¹(r − Hλ). No VI is solved if no predicted gap is negative.
/// Otherwise the active set is sought by primal-dual steps from that of the previous step, from which it
/// mostly differs in few candidates. Where these do not settle soon, PETSc's VI solver finds the set from the
/// VI in the gaps, 0 ≤ g ⟂ S⁻¹(g − g⁰) ≥ 0: S⁻¹, unlike S, is close to an M-matrix, for which reduced-space
/// Newton does not cycle. A dual active-set method replaces PETSc's solver where candidates are linearly
/// dependent, so that S is singular, and is the last resort where both others fail. Active sets that depend
/// on LAPACK's rounding are determined on rank 0. Where columns of S are computed on demand, primal-dual
/// steps are followed by block pivoting instead. Laws that are not symmetric are solved by Newton steps,
/// after sweeps over the groups where these cycle. The resulting gaps are accurate to the rounding of the
/// motion without contact. In a step that is long compared with a fall through the body, this exceeds the
/// error allowed of a gap, and the gaps are refined from the residual.
class CondensedSolver final : public ContactStepSolver {
public:
  /// Takes the condensation of the step operator `D`, whose solves leave the relative error `tolerance`, and
  /// the body's diameter (m). Without a `residual` no solution is refined. Collective. `rows` must outlive
  /// this object. PETSc options with the prefix `-condensed_vi_` are honoured.
  CondensedSolver(const ConstraintRows& rows, double diameter, Mat D,
                  std::unique_ptr<const Condensation> condensation, Residual residual, double tolerance = 0);

  [[nodiscard]] Workspace workspace() const override;
  void solve(const ContactProblem& step, Workspace& work) const override;
  void solve_linearised(const LinearisedContact& step, Workspace& work) const override {
    delassus_.solve_linearised(step, work);
  }
  void solve_transposed(const LinearisedContact& step, Workspace& work) const override {
    delassus_.solve_transposed(step, work);
  }
  [[nodiscard]] double bytes() const override { return delassus_.bytes(); }

private:
  /// Computes λ, with zero gaps on work.set and zero forces elsewhere, and the gaps g⁰ + Sλ of all
  /// candidates.
  void solve_on_set(ContactState& state, Workspace& work) const;
  /// Takes at most `most` primal-dual steps, until the state is complementary to rounding and within the gap
  /// `negligible` (m).
  void settle(ContactState& state, std::span<const double> psi, double negligible, int most,
              Workspace& work) const;
  /// Whether the state is complementary to rounding of the step's own motion.
  [[nodiscard]] bool holds(const ContactState& state, std::span<const double> psi,
                           std::span<const double> gap0) const;
  /// Finds work.set by PETSc's VI solver, starting from the gaps of `state`; if it fails, the set becomes the
  /// candidates with negative predicted gaps.
  void find_set(ContactState& state, Workspace& work) const;
  /// Finds work.set by the dual active-set method, which starts without contact and terminates for every S.
  /// Throws SolverFailure if the gaps cannot all be made nonnegative.
  void find_independent_set(ContactState& state, Workspace& work) const;
  /// Finds work.set by find_set() where S is regular and of a size that PETSc can handle, else by
  /// find_independent_set().
  void search(ContactState& state, Workspace& work) const;
  /// Computes λ and gaps by active sets alone: primal-dual steps, then block pivoting. Collective.
  void pivot(ContactState& state, std::span<const double> psi, Workspace& work) const;
  /// Computes λ, gaps and the active set from predicted gaps, some of them negative. Collective.
  void solve_by_sets(const ContactProblem& step, Workspace& work) const;
  /// Sets the equation of a group's law in the next Newton step; returns false if the group opens.
  [[nodiscard]] bool next(int group, const ContactState& state, LawEquation& equation) const;
  /// Changes a multiplier, and the gaps accordingly.
  void push(int row, double change, ContactState& state) const;
  /// Takes a Newton step with the equations of all laws. Collective.
  void newton_step(ContactState& state, Workspace& work) const;
  /// Solves the law of one group, the multipliers of the others fixed: a step of block Gauss–Seidel.
  void relax(int group, ContactState& state) const;
  /// Computes ρ and gaps by Newton steps and, where these do not settle, sweeps before them. Collective.
  void solve_by_laws(const ContactProblem& step, Workspace& work) const;
  /// Rounding error of predicted gaps, from the size of a step's own motion, m.
  [[nodiscard]] double rounding(std::span<const double> psi, std::span<const double> gap0) const;
  /// Refines the solution found on work.set to rounding of its own size, iteratively, with the gaps on the
  /// set kept at zero. Updates work.set by primal-dual steps from the refined solution. Collective.
  void refine(Vec r, std::span<const double> psi, ContactState& state, Vec y, Workspace& work) const;
  /// Broadcasts the set, λ and number of steps that rank 0 found. Collective.
  void decided(ContactState& state, Workspace& work) const;
  [[nodiscard]] std::unique_ptr<CondensedVi> make_vi() const;

  const ConstraintRows& rows_;
  DelassusOperator delassus_;
  Complementarity complementarity_;
  Residual residual_;
  double tolerance_;
  double length_unit_; ///< unit of gaps in PETSc's VI: a negligible gap, m
};

} // namespace signorini::contact
