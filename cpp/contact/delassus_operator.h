// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/solver/contact_step_solver.h"

namespace signorini::contact {

/// The Delassus operator S = HᵀD⁻¹H, which condenses the step operator D to the contact candidates
/// (docs/method.md section 5).
class DelassusOperator {
public:
  /// Takes ownership of a condensation of D, made for `rows`. `rows` must outlive this object. Collective.
  DelassusOperator(const ConstraintRows& rows, std::unique_ptr<const Condensation> condensation);

  /// Whether all columns of S have been computed.
  [[nodiscard]] bool complete() const { return condensation_->complete(); }
  /// Column of S that belongs to a row of H, the same on every rank. If complete() is false, the column must
  /// have been computed by prepare() or by a solve on a set that contains the row. S is symmetric. It is
  /// singular if candidates are linearly dependent.
  [[nodiscard]] std::span<const double> column(int row) const { return condensation_->column(row); }
  /// Computes the columns of S for the given rows that have not been computed yet. Collective. Throws
  /// SolverFailure.
  void prepare(std::span<const int> rows) const { condensation_->prepare(rows); }

  /// Returns S⁻¹ (rows × rows); complete() must be true. Throws SolverFailure if S is singular.
  [[nodiscard]] std::vector<double> inverse() const;

  /// Replaces b by S_AA⁻¹ b for a linearly independent `set` A. b has one entry per candidate of the set, and
  /// is the same on every rank afterwards. Collective. Throws SolverFailure if S_AA is singular.
  void solve_active(const ActiveSet& set, std::span<double> b, Workspace& work) const;

  /// Solves (E S + F) ρ = b or, if `transposed`, the transposed system, for the `equations` of a set of
  /// groups. b has one entry for each row of the groups, group by group; it is replaced by the solution,
  /// which is the same on every rank. Returns the sign of the system's determinant on rank 0, 1 elsewhere.
  /// Collective. Throws SolverFailure.
  int solve_equations(const ActiveSet& set, std::span<const LawEquation> equations, bool transposed,
                      std::span<double> b, Workspace& work) const;

  [[nodiscard]] Workspace workspace() const;

  /// Computes the predicted gaps g⁰ = g(D⁻¹r), m, for the given ψ (m), and stores the first half of the solve
  /// in `half_solve`. Collective. Throws SolverFailure.
  void predict_gap(Vec r, const Guess& guess, std::span<const double> psi, std::span<double> gap,
                   HalfSolve& half_solve) const;

  /// Solves D y = r − Hλ with g(y) = 0 on a linearly independent `set` and λ = 0 elsewhere. predict_gap()
  /// must have stored the half solve for r in `work.half_solve`. On entry `lambda` contains the λ computed
  /// from the predicted gaps; it is refined, at most three times, until the gaps on the set are zero up to
  /// rounding. ψ is in m. `gap` becomes g(y), m. Collective. Throws SolverFailure.
  void finish_closed(const ActiveSet& set, std::span<const double> psi, std::span<double> lambda,
                     std::span<double> gap, Vec y, Workspace& work) const;

  /// Completes a solve for given multipliers: computes y = D⁻¹ (r − Hλ), where r is the right-hand side of
  /// `work.half_solve`. `gap` becomes g(y), m. Collective. Throws SolverFailure.
  void finish(std::span<const double> psi, std::span<const double> lambda, std::span<double> gap, Vec y,
              Workspace& work) const;

  /// Solves a linearised step; solve_transposed() solves the transposed step. Collective. Both throw
  /// SolverFailure.
  void solve_linearised(const LinearisedContact& step, Workspace& work) const;
  void solve_transposed(const LinearisedContact& step, Workspace& work) const;

  /// Memory of S and the condensation on all ranks, in addition to D's factor, bytes. Collective.
  [[nodiscard]] double bytes() const;

private:
  /// Does the work of solve_active() on this rank alone.
  void solve_here(const ActiveSet& set, std::span<double> b, Workspace& work) const;
  /// Does the work of finish_closed(), but sets `motion` to Hᵀy instead of computing the gaps. Refines λ, at
  /// most three times, until |Hᵀy − ψ| on the set is at most `digits` machine epsilons relative to the
  /// largest entry of Hᵀy and ψ, or to `scale` if that is larger.
  void refine_on_set(const ActiveSet& set, std::span<const double> psi, std::span<double> lambda,
                     std::span<double> motion, Vec y, Workspace& work, double digits, double scale = 0) const;
  /// Solves a linearised step whose laws are not symmetric or, if `transposed`, its transpose.
  void solve_by_equations(const LinearisedContact& step, bool transposed, Workspace& work) const;

  const ConstraintRows& rows_;
  std::unique_ptr<const Condensation> condensation_;
  const std::vector<double> zero_; ///< zeros, one for each row
};

} // namespace signorini::contact
