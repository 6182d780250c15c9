// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/rigid_motions.h"
#include "scene/scene.h"
#include "trajectory/time_integrator.h"

namespace signorini::trajectory {

/// Moves a body that is dropped (initial.drop) along gravity, until its first candidate touches an obstacle,
/// and adds the speed of the fall: changes the displacement y and the velocity v at the start. The gaps are
/// the linearised ones, exact for half-spaces. Collective. Throws UserError if no candidate is above an
/// obstacle.
void drop(const step::Stepper& stepper, const scene::Scene& scene, Vec y, Vec v);

/// Returns whether a candidate touches an obstacle again before `until` (s) by the rigid part of the body's
/// velocity, without other forces, as one does that the body's rotation brings down. `rigid`: motions of the
/// stepper's body. Collective.
[[nodiscard]] bool touches_again(const step::Stepper& stepper, const fem::RigidMotions& rigid,
                                 const Frame& frame, double until);

} // namespace signorini::trajectory
