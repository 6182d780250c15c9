// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "step/step.h"
#include <vector>

namespace signorini::diagnostics {

/// Warns if contact did the work `contact_work` (J, in the plane J/m) in a motion of `largest_energy` though
/// its obstacles are at rest. What meets an obstacle within a step is stopped at once: as far as a wave comes
/// in it, and at least the mass of the nodes in contact. Names the step that would do; empty where an
/// obstacle moves. Not collective.
std::vector<Warning> contact_loss(const step::Stepper& stepper, const scene::Scene& scene,
                                  double contact_work, double largest_energy);

} // namespace signorini::diagnostics
