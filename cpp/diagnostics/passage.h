// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "trajectory/integrate.h"
#include <optional>
#include <vector>

namespace signorini::diagnostics {

/// Checks whether a body and an obstacle could pass through each other within a step, since gaps are known at
/// the ends of steps alone: whether they approach by more than half the depth of either from where they could
/// touch.
class Passage {
public:
  /// The references must outlive this object.
  explicit Passage(const step::Stepper& stepper);

  /// Takes the frame after the last one, from frame 0 on. Collective.
  void observe(const trajectory::Frame& frame);
  /// Of each obstacle of which that is so, its worst step.
  [[nodiscard]] std::vector<Warning> warnings() const;

private:
  struct Worst {
    double share = 0, path = 0, depth = 0; ///< of the depth; m
    step::TimeStep step;
  };
  const step::Stepper& stepper_;
  std::optional<contact::ContactPairs::Gaps> now_, before_;
  std::vector<double> gaps_, moved_; ///< gaps, and ν·y, after the last step (m)
  std::vector<Worst> worst_;         ///< by obstacle
};

} // namespace signorini::diagnostics
