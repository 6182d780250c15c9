// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/constraint_rows.h"
#include "contact/contact_state.h"

namespace signorini::contact {

/// Classifies candidates as open, weakly or strongly active (4.36), and throws SolverFailure unless the state
/// is complementary. Thresholds for zero are relative to the quantities of the step itself, by rounding or an
/// iterative solver's tolerance. Fixed thresholds would fail: contact forces λ are τ²/2 times forces, and in
/// short steps the weight of a body moves its nodes by less than any fixed part of its diameter.
class Complementarity {
public:
  /// Takes the body's diameter (m) and step operator D. Collective. `rows` must outlive this object.
  Complementarity(const ConstraintRows& rows, double diameter, Mat D);

  /// Sets status and linearisation of `state` from its λ and gaps and the step's solution y, whose relative
  /// error from the solver is `tolerance`, 0 for rounding alone. Collective. Throws SolverFailure if λ
  /// and gaps are not all finite or not complementary.
  void classify(ContactState& state, Vec y, double tolerance = 0) const;

  /// Penetration (m) that rounding may leave, for displacements of `size` (m) and a penetration without
  /// contact forces of at most `deepest` (m).
  [[nodiscard]] double negligible_gap(double deepest, double size) const;

  /// Whether g ≥ 0, λ ≥ 0 and one of them is zero, up to a `negligible` gap (m) and up to forces that are
  /// negligible for displacements of `size` (m) found with the relative `tolerance`.
  [[nodiscard]] bool holds(std::span<const double> lambda, std::span<const double> gap, double negligible,
                           double size, double tolerance = 0) const {
    return holds_to(negligible, negligible_motion(lambda, size, tolerance), lambda, gap);
  }

  /// Whether g ≥ 0, λ ≥ 0 and one of them is zero, up to a `negligible` gap (m) and up to forces that move
  /// their node alone by less than that.
  [[nodiscard]] bool holds_within(double negligible, std::span<const double> lambda,
                                  std::span<const double> gap) const {
    return holds_to(negligible, negligible, lambda, gap);
  }

private:
  /// Motion (m) of a node alone, the others fixed, below which the force that causes it counts as zero.
  [[nodiscard]] double negligible_motion(std::span<const double> lambda, double size, double tolerance) const;
  [[nodiscard]] bool holds_to(double negligible, double motion, std::span<const double> lambda,
                              std::span<const double> gap) const;

  const ConstraintRows& rows_;
  double diameter_, gap_tolerance_;
  std::vector<double> stiffness_; ///< stiffness (m) of D for a candidate's node moved alone in its direction
};

} // namespace signorini::contact
