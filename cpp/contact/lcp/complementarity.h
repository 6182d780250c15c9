// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/constraint_rows.h"
#include "contact/contact_state.h"

namespace signorini::contact {

/// Classifies candidates as open, weakly active or strongly active (4.36), and checks that gaps and forces
/// are complementary. What counts as zero is measured relative to the quantities of the step itself, by
/// rounding errors or by the tolerance of an iterative solver. Fixed thresholds would fail: the multipliers λ
/// are τ²/2 times forces, and in short steps its weight moves the nodes of a body by less than any fixed
/// fraction of its diameter.
class Complementarity {
public:
  /// `diameter`: diameter of the body, m; `D`: step operator. `rows` must outlive this object. Collective.
  Complementarity(const ConstraintRows& rows, double diameter, Mat D);

  /// Sets the status and the linearisation of `state` from its multipliers λ and gaps. `y`: solution of the
  /// step; `tolerance`: relative error of y due to an iterative solver, 0 for a direct one. Collective.
  /// Throws SolverFailure if λ and gaps are not all finite or not complementary.
  void classify(ContactState& state, Vec y, double tolerance = 0) const;

  /// Penetration (m) that rounding errors may cause. `deepest_gap`: largest penetration without contact
  /// forces, m; `displacement`: largest displacement, m.
  [[nodiscard]] double negligible_gap(double deepest_gap, double displacement) const;

  /// Whether the laws of all candidates are satisfied, for unilateral contact g ≥ 0, λ ≥ 0 and one of them
  /// zero. Gaps up to `negligible` (m) count as zero, as do forces within the error of a solve with
  /// displacements up to `size` (m) and the relative error `tolerance`.
  [[nodiscard]] bool holds(std::span<const double> lambda, std::span<const double> gap, double negligible,
                           double size, double tolerance = 0) const {
    return holds_to(negligible, negligible_motion(lambda, size, tolerance), lambda, gap);
  }

  /// Whether the laws of all candidates are satisfied, for unilateral contact g ≥ 0, λ ≥ 0 and one of them
  /// zero. Gaps up to `negligible` (m) count as zero, as do forces that would move their node alone by at
  /// most this length.
  [[nodiscard]] bool holds_within(double negligible, std::span<const double> lambda,
                                  std::span<const double> gap) const {
    return holds_to(negligible, negligible, lambda, gap);
  }

private:
  /// Length (m) for zero forces: a force counts as zero if it would move its node by less, with all other
  /// nodes fixed.
  [[nodiscard]] double negligible_motion(std::span<const double> lambda, double size, double tolerance) const;
  [[nodiscard]] bool holds_to(double negligible, double motion, std::span<const double> lambda,
                              std::span<const double> gap) const;

  const ConstraintRows& rows_;
  double diameter_, gap_tolerance_;
  std::vector<double> stiffness_; ///< stiffness of D against moving one candidate's node alone (m entries)
};

} // namespace signorini::contact
