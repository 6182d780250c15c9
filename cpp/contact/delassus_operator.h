// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/elimination.h"

namespace signorini::contact {

struct LinearisedContact;

/// The Delassus operator S = HᵀD⁻¹H: the step operator D condensed to the contact candidates (docs/method.md
/// section 5).
class DelassusOperator {
public:
  /// Collective. `rows` must outlive this object.
  DelassusOperator(const ConstraintRows& rows, std::unique_ptr<const Elimination> elimination);

  /// S (m × m), symmetric, the same on every rank; singular where candidates are linearly dependent.
  [[nodiscard]] const std::vector<double>& S() const { return S_; }

  /// S⁻¹ (m × m). Throws SolverFailure if S is singular.
  [[nodiscard]] std::vector<double> inverse() const;

  /// b ← S_AA⁻¹ b for an independent `set` A; b has one entry per candidate of the set, and is the same on
  /// every rank on return. Collective. Throws SolverFailure if S_AA is singular.
  void solve_active(const ActiveSet& set, std::span<double> b, Workspace& work) const;

  [[nodiscard]] Workspace workspace() const;

  /// Predicted gaps g⁰ = g(D⁻¹r) (m), in metres, for the given ψ (m). Collective.
  void predict_gap(Vec r, std::span<const double> psi, std::span<double> gap, Prediction& prediction) const;

  /// Solves D y = r − Hλ with g(y) = 0 on an independent `set` and λ = 0 elsewhere, for the r of
  /// `work.prediction` and the given ψ (m). `lambda` (m) holds the λ found from the predicted gaps on entry,
  /// and on return λ refined until the gaps on the set vanish to rounding; `gap` (m) becomes g(y).
  /// Collective. Throws SolverFailure.
  void finish_closed(const ActiveSet& set, std::span<const double> psi, std::span<double> lambda,
                     std::span<double> gap, Vec y, Workspace& work) const;

  /// Collective. Throws SolverFailure.
  void solve_linearised(const LinearisedContact& step, Workspace& work) const;

  /// Memory on all ranks, bytes. Collective.
  [[nodiscard]] double bytes() const;

private:
  /// solve_active() on this rank alone.
  void solve_here(const ActiveSet& set, std::span<double> b, Workspace& work) const;
  /// finish_closed(), returning Hᵀy (m) in `motion` instead of gaps; `digits`: how far these may be off on
  /// the set, in units of the last place of the largest.
  void finish(const ActiveSet& set, std::span<const double> psi, std::span<double> lambda,
              std::span<double> motion, Vec y, Workspace& work, double digits) const;

  const ConstraintRows& rows_;
  std::unique_ptr<const Elimination> elimination_;
  std::vector<double> S_;
  const std::vector<double> zero_; ///< (m)
};

} // namespace signorini::contact
