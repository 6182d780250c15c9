// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/constraint_rows.h"
#include "contact/law.h"

namespace signorini::contact {

/// Classifies candidates as open, weakly active or strongly active (4.36), and checks that gaps and forces
/// are complementary. The limits below which gaps and forces count as zero follow from the step itself: from
/// its rounding errors and from the tolerance of an iterative solver. Fixed limits would fail in short steps,
/// where the multipliers λ, τ²/2 times forces, are small and the weight of a body moves its nodes by less
/// than any fixed fraction of its diameter.
class Complementarity {
public:
  /// `diameter`: diameter of the body, m; `diagonal`: that of the step operator D. `rows` must outlive this
  /// object. Collective.
  Complementarity(const ConstraintRows& rows, double diameter, Vec diagonal);

  /// Sets the status and the linearisation of `state` from its multipliers λ and gaps. `y`: solution of the
  /// step; `tolerance`: relative error of y due to an iterative solver, 0 for a direct one; `residual`: up to
  /// which the laws were solved, m (Law::residual). Collective. Throws SolverFailure if λ and gaps are not
  /// all finite or not complementary.
  void classify(ContactState& state, Vec y, double tolerance = 0, double residual = 0) const;

  /// Penetration (m) that rounding errors may cause. `deepest_gap`: largest penetration without contact
  /// forces, m; `displacement`: largest displacement, m.
  [[nodiscard]] double negligible_gap(double deepest_gap, double displacement) const;

  /// Whether the laws of all candidates are satisfied; for unilateral contact, 0 ≤ λ ⟂ g ≥ 0. Gaps up to
  /// `negligible` (m) count as zero, as do forces within the error of a solve with displacements up to `size`
  /// (m) and the relative error `tolerance`.
  [[nodiscard]] bool holds(const ContactState& state, double negligible, double size,
                           double tolerance = 0) const {
    return holds_to(negligible, negligible_motion(state.lambda, size, tolerance), state);
  }

  /// Whether the laws of all candidates are satisfied; for unilateral contact, 0 ≤ λ ⟂ g ≥ 0. Gaps up to
  /// `negligible` (m) count as zero, as do forces that would move their node by at most `negligible` if all
  /// other nodes were fixed.
  [[nodiscard]] bool holds_within(double negligible, const ContactState& state) const {
    return holds_to(negligible, negligible, state);
  }

  /// Gaps by which a unit of a candidate's multipliers moves its node if all other nodes are fixed.
  [[nodiscard]] Compliance compliance(int candidate) const;
  /// Returns compliance() of all candidates.
  [[nodiscard]] std::vector<Compliance> compliances() const;

private:
  /// Displacement (m) below which forces count as zero: the one by which a force would move its node if all
  /// other nodes were fixed. `size`: largest displacement, m; `tolerance`: relative error of displacements.
  [[nodiscard]] double negligible_motion(std::span<const double> lambda, double size, double tolerance) const;
  [[nodiscard]] bool holds_to(double negligible, double motion, const ContactState& state) const;

  const ConstraintRows& rows_;
  double diameter_, gap_tolerance_;
  /// For each row of H, the multiplier that would move its node alone by 1 m.
  std::vector<double> multiplier_per_motion_;
};

} // namespace signorini::contact
