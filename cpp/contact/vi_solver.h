#pragma once
#include "contact/constraints.h"
#include "contact/contact_state.h"

namespace signorini::contact {

/// Solver of one contact step: minimise ½ y·Dy − r·y over g(y) ≥ 0 (4.22).
class ViSolver {
public:
  ViSolver();
  virtual ~ViSolver() = default;

  /// Solves for `y`, which holds a guess on entry, and for `state`, made for the m candidates; `psi` (m) are
  /// the gaps of the undeformed body at the end of the step, `previous` is the previous step's contact, from
  /// which the search starts. Collective. Throws SolverFailure with reason and residual.
  virtual void solve(Vec r, std::span<const double> psi, const ContactSets& previous, ContactState& state,
                     Vec y) const = 0;

protected:
  /// Counts a step in which the inequality mattered: the motion without contact would have penetrated.
  static void count_solved();
};

/// Tells candidates apart as open, weak and strong, and throws SolverFailure unless the state is
/// complementary. What counts as zero is what rounding, or an iterative solver's tolerance, leaves of the
/// quantities of the step itself, and no figure of its own: contact forces λ are τ²/2 times forces, and with
/// short steps the weight of a body moves its nodes by less than any fixed part of its diameter.
class Complementarity {
public:
  /// Collective.
  Complementarity(const Constraints& constraints, Mat D);

  /// Of a step's solution y, whose solver left an error of `tolerance` relative to it, 0 for rounding alone.
  /// Collective.
  void classify(ContactState& state, Vec y, double tolerance = 0) const;

  /// The penetration (m) that rounding may leave of one that was `deepest` (m) without forces, in a motion of
  /// a `size` (m).
  [[nodiscard]] double negligible_gap(double deepest, double size) const;

  /// Whether g ≥ 0 but for a `negligible` gap (m), and λ ≥ 0 but for the forces that are negligible in a motion
  /// of a `size` (m) found with `tolerance`.
  [[nodiscard]] bool holds(std::span<const double> lambda, std::span<const double> gap, double negligible,
                           double size, double tolerance = 0) const {
    return holds_to(negligible, negligible_motion(lambda, size, tolerance), lambda, gap);
  }

  /// The same where a force is negligible if it moves its node, the others held, by less than a gap that is.
  [[nodiscard]] bool holds_within(double negligible, std::span<const double> lambda,
                                  std::span<const double> gap) const {
    return holds_to(negligible, negligible, lambda, gap);
  }

private:
  /// The motion (m) of a node, the others held, below which the force that makes it is zero.
  [[nodiscard]] double negligible_motion(std::span<const double> lambda, double size, double tolerance) const;
  [[nodiscard]] bool holds_to(double negligible, double motion, std::span<const double> lambda,
                              std::span<const double> gap) const;

  const Constraints& constraints_;
  double gap_tolerance_;
  std::vector<double> stiffness_; ///< of D against moving the candidate's node alone (m)
};

} // namespace signorini::contact
