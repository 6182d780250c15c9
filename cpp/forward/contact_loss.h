// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "forward/balance.h"
#include "forward/warning.h"
#include "scene/scene.h"
#include <vector>

namespace signorini::forward {

/// Checks whether contact took energy, which obstacles at rest do not. What meets an obstacle within a step
/// is stopped at once: as far as a wave comes in it, and at least the mass of the nodes in contact.
class ContactLoss {
public:
  /// The references must outlive this object.
  ContactLoss(const Stepper& stepper, const scene::Scene& scene);

  /// Takes the balance of the frame after the last one, from frame 0 on. Not collective.
  void observe(const StepBalance& balance);

  /// A warning with the length of steps that would do; none where an obstacle moves.
  /// Not collective.
  [[nodiscard]] std::vector<Warning> warnings() const;

private:
  const Stepper& stepper_;
  const scene::Scene& scene_;
  bool rest_;
  double lost_ = 0, largest_ = 0; ///< in contact; the largest energy, J, in the plane J/m
};

} // namespace signorini::forward
