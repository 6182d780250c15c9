// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include "step/step.h"

namespace signorini::trajectory {

/// Moves a body that is dropped (initial.drop) along gravity, until its first candidate touches an obstacle,
/// and adds the speed of the fall: changes the displacement y and the velocity v at the start. The gaps are
/// the linearised ones, exact for half-spaces. Collective. Throws UserError if no candidate is above an
/// obstacle.
void drop(const step::Stepper& stepper, const scene::Scene& scene, Vec y, Vec v);

} // namespace signorini::trajectory
