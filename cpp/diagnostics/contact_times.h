// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/contact_state.h"
#include "step/time_grid.h"
#include <utility>

namespace signorini::diagnostics {

/// When some candidates of a motion are in contact, to a part of a step (docs/method.md section 8).
///
/// Steps tell contact to half of their length. Within its first step an interval of contact begins where the
/// gaps before it, continued linearly, vanish, and it ends where those after it do. With a and b the first
/// and the last step of the interval with a force, and i the candidates that have one there,
///     start = t_{a−1} + min_i τ_{a−1} g_{a−1} / (g_{a−2} − g_{a−1})
///     end   = t_{b+1} − min_i τ_{b+2} g_{b+1} / (g_{b+2} − g_{b+1})
/// within the steps a and b + 1, in whose middle they are where the two gaps do not fall towards the contact
/// or there are no two. They are off by O(τ²) where bodies meet and part with a speed; with 1/2 throughout
/// the times are those that counting steps gives.
class ContactTimes {
public:
  /// `candidates`: numbers of those that are observed.
  explicit ContactTimes(std::vector<int> candidates) : candidates_(std::move(candidates)) {}

  /// Takes the contact of all candidates after a step, for k = 0, 1, 2 … in turn.
  void observe(const step::TimeStep& step, const contact::ContactState& contact);

  /// s.
  struct Interval {
    double start, end;
  };
  /// Those of the frames observed so far; one that lasts ends with the last of them.
  [[nodiscard]] std::vector<Interval> intervals() const;

private:
  /// Time from the begin of step k until an interval begins in it, and from the end of one in step k − 1 to
  /// the end of that, s.
  [[nodiscard]] double until_onset(const std::vector<int>& touching) const;
  [[nodiscard]] double since_release() const;

  std::vector<int> candidates_;
  std::vector<double> before_, last_, now_; ///< gaps after steps k − 2, k − 1 and k
  std::vector<int> touching_;               ///< places, among the candidates, of those in contact in step k
  std::vector<int> held_;                   ///< likewise, in the last step of the last interval
  std::vector<Interval> intervals_;
  step::TimeStep step_, step_before_; ///< steps k and k − 1
  bool ending_ = false; ///< step k is the first without contact: the gap after the next one tells the end
};

} // namespace signorini::diagnostics
