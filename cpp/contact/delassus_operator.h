// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/solver/contact_step_solver.h"

namespace signorini::contact {

/// The Delassus operator S = HᵀD⁻¹H: the step operator D condensed to the contact candidates (docs/method.md
/// section 5).
class DelassusOperator {
public:
  /// Takes the condensation of D to `rows`, which must outlive this object. Collective.
  DelassusOperator(const ConstraintRows& rows, std::unique_ptr<const Condensation> condensation);

  /// Whether all columns of S are known.
  [[nodiscard]] bool complete() const { return condensation_->complete(); }
  /// Column S_·row. If S is incomplete the row must be prepared; the solves below prepare the rows of sets. S
  /// is symmetric, the same on every rank, and singular if candidates are linearly dependent.
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
  /// `work.half_solve` and the given ψ (m). On entry `lambda` (m) is the λ found from the predicted gaps, on
  /// return it is refined until the gaps on the set vanish to rounding; `gap` (m) becomes g(y).
  /// Collective. Throws SolverFailure.
  void finish_closed(const ActiveSet& set, std::span<const double> psi, std::span<double> lambda,
                     std::span<double> gap, Vec y, Workspace& work) const;

  /// Second half of a solve, with the multipliers known; `gap` becomes g(y). Collective. Throws
  /// SolverFailure.
  void finish(std::span<const double> psi, std::span<const double> lambda, std::span<double> gap, Vec y,
              Workspace& work) const;

  /// Solves a linearised step; solve_transposed() solves its transpose. Collective. Both throw SolverFailure.
  void solve_linearised(const LinearisedContact& step, Workspace& work) const;
  void solve_transposed(const LinearisedContact& step, Workspace& work) const;

  /// Memory on all ranks, bytes. Collective.
  [[nodiscard]] double bytes() const;

private:
  /// Does solve_active() on this rank alone.
  void solve_here(const ActiveSet& set, std::span<double> b, Workspace& work) const;
  /// Does finish_closed(), returning Hᵀy (m) in `motion` instead of gaps. `digits`: error of Hᵀy allowed on
  /// the set, in units in the last place of the largest.
  void close(const ActiveSet& set, std::span<const double> psi, std::span<double> lambda,
             std::span<double> motion, Vec y, Workspace& work, double digits) const;
  /// Solves a linearised step whose laws are not symmetric, or its transpose.
  void solve_by_equations(const LinearisedContact& step, bool transposed, Workspace& work) const;

  const ConstraintRows& rows_;
  std::unique_ptr<const Condensation> condensation_;
  const std::vector<double> zero_; ///< zeros, one per row
};

} // namespace signorini::contact
