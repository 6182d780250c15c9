// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/solver/contact_step_solver.h"

namespace signorini::contact {

/// The Delassus operator S = HᵀD⁻¹H: the step operator D condensed to the contact candidates (docs/method.md
/// section 5).
class DelassusOperator {
public:
  /// Collective. `rows` must outlive this object.
  DelassusOperator(const ConstraintRows& rows, std::unique_ptr<const Condensation> condensation);

  /// Whether all columns of S are known.
  [[nodiscard]] bool complete() const { return condensation_->complete(); }
  /// S_·row; of an incomplete S for rows that were prepared, as those of sets are by the solves below. S is
  /// symmetric, the same on every rank, and singular where candidates are linearly dependent.
  [[nodiscard]] std::span<const double> column(int row) const { return condensation_->column(row); }
  /// Computes columns of an incomplete S. Collective. Throws SolverFailure.
  void prepare(std::span<const int> rows) const { condensation_->prepare(rows); }

  /// S⁻¹ of a complete S. Throws SolverFailure if S is singular.
  [[nodiscard]] std::vector<double> inverse() const;

  /// b ← S_AA⁻¹ b for an independent `set` A; b has one entry per candidate of the set, and is the same on
  /// every rank on return. Collective. Throws SolverFailure if S_AA is singular.
  void solve_active(const ActiveSet& set, std::span<double> b, Workspace& work) const;

  /// Solves (E S + F) ρ = b in place, or the transposed system, for the `equations` of a set of groups; b has
  /// an entry for each of their rows, group by group, and is the same on every rank on return. Collective.
  /// Throws SolverFailure.
  void solve_equations(const ActiveSet& set, std::span<const LawEquation> equations, bool transposed,
                       std::span<double> b, Workspace& work) const;

  [[nodiscard]] Workspace workspace() const;

  /// Predicted gaps g⁰ = g(D⁻¹r), in metres, for the given ψ. Collective. Throws SolverFailure.
  void predict_gap(Vec r, const Guess& guess, std::span<const double> psi, std::span<double> gap,
                   HalfSolve& half_solve) const;

  /// Solves D y = r − Hλ with g(y) = 0 on an independent `set` and λ = 0 elsewhere, for the r of
  /// `work.half_solve` and the given ψ (m). `lambda` (m) holds the λ found from the predicted gaps on entry,
  /// and on return λ refined until the gaps on the set vanish to rounding; `gap` (m) becomes g(y).
  /// Collective. Throws SolverFailure.
  void finish_closed(const ActiveSet& set, std::span<const double> psi, std::span<double> lambda,
                     std::span<double> gap, Vec y, Workspace& work) const;

  /// Second half of a solve, with the multipliers known; `gap` becomes g(y). Collective. Throws
  /// SolverFailure.
  void finish(std::span<const double> psi, std::span<const double> lambda, std::span<double> gap, Vec y,
              Workspace& work) const;

  /// Collective. Throw SolverFailure.
  void solve_linearised(const LinearisedContact& step, Workspace& work) const;
  void solve_transposed(const LinearisedContact& step, Workspace& work) const;

  /// Memory on all ranks, bytes. Collective.
  [[nodiscard]] double bytes() const;

private:
  /// solve_active() on this rank alone.
  void solve_here(const ActiveSet& set, std::span<double> b, Workspace& work) const;
  /// finish_closed(), returning Hᵀy (m) in `motion` instead of gaps; `digits`: how far these may be off on
  /// the set, in units of the last place of the largest.
  void close(const ActiveSet& set, std::span<const double> psi, std::span<double> lambda,
             std::span<double> motion, Vec y, Workspace& work, double digits) const;
  /// A linearised step whose laws are not symmetric, or its transpose.
  void solve_by_equations(const LinearisedContact& step, bool transposed, Workspace& work) const;

  const ConstraintRows& rows_;
  std::unique_ptr<const Condensation> condensation_;
  const std::vector<double> zero_; ///< of rows
};

} // namespace signorini::contact
