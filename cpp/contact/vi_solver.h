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
  virtual void solve(Vec r, std::span<const double> psi, const ContactState& previous, ContactState& state,
                     Vec y) const = 0;

protected:
  /// Counts a step in which the inequality mattered: the motion without contact would have penetrated.
  static void count_solved();
};

/// Tells candidates apart as open, weak and strong, and throws SolverFailure unless the state is
/// complementary to within the gap tolerance: a force counts as zero if it moves its node, the others held,
/// by less than that.
class Complementarity {
public:
  /// Collective.
  Complementarity(const Constraints& constraints, Mat D);

  void classify(ContactState& state) const;

  /// Whether g ≥ 0 and λ ≥ 0 to within the tolerance.
  [[nodiscard]] bool holds(std::span<const double> lambda, std::span<const double> gap) const {
    return holds_within(gap_tolerance_, lambda, gap);
  }

  /// The same for a gap (m) other than the tolerance.
  [[nodiscard]] bool holds_within(double negligible, std::span<const double> lambda,
                                  std::span<const double> gap) const;

private:
  double gap_tolerance_;
  std::vector<double> stiffness_; ///< of D against moving the candidate's node alone (m)
};

} // namespace signorini::contact
