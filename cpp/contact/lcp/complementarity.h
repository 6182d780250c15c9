// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/constraint_rows.h"
#include "contact/contact_state.h"

namespace signorini::contact {

/// Classifies candidates as open, weakly or strongly active (4.36), and throws SolverFailure unless the state
/// is complementary. What counts as zero is relative to the quantities of the step itself, by rounding or an
/// iterative solver's tolerance. Fixed thresholds would not do: contact forces λ are τ²/2 times forces, and
/// in short steps the weight of a body moves its nodes by less than any fixed part of its diameter.
class Complementarity {
public:
  /// For a body of a diameter, m. Collective. `rows` must outlive this object.
  Complementarity(const ConstraintRows& rows, double diameter, Mat D);

  /// Sets status and linearisation of `state` from its λ and gaps and the step's solution y, whose relative
  /// error from the solver is `tolerance`, 0 for rounding alone. Collective. Throws SolverFailure if they are
  /// not finite or not complementary.
  void classify(ContactState& state, Vec y, double tolerance = 0) const;

  /// The penetration (m) that rounding may leave if it was at most `deepest` (m) without contact forces and
  /// displacements are of `size` (m).
  [[nodiscard]] double negligible_gap(double deepest, double size) const;

  /// Whether g ≥ 0, λ ≥ 0 and one of them is zero, up to a `negligible` gap (m) and up to forces that are
  /// negligible for displacements of `size` (m) found with the relative `tolerance`.
  [[nodiscard]] bool holds(std::span<const double> lambda, std::span<const double> gap, double negligible,
                           double size, double tolerance = 0) const {
    return holds_to(negligible, negligible_motion(lambda, size, tolerance), lambda, gap);
  }

  /// Likewise, where a force is negligible if it moves its node alone by less than the `negligible` gap (m).
  [[nodiscard]] bool holds_within(double negligible, std::span<const double> lambda,
                                  std::span<const double> gap) const {
    return holds_to(negligible, negligible, lambda, gap);
  }

private:
  /// A force counts as zero if it moves its node alone, the others held, by less than this (m).
  [[nodiscard]] double negligible_motion(std::span<const double> lambda, double size, double tolerance) const;
  [[nodiscard]] bool holds_to(double negligible, double motion, std::span<const double> lambda,
                              std::span<const double> gap) const;

  const ConstraintRows& rows_;
  double diameter_, gap_tolerance_;
  std::vector<double> stiffness_; ///< of D against moving a candidate's node alone along its direction (m)
};

} // namespace signorini::contact
