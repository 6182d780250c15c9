// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/operators.h"
#include "step/load.h"
#include "step/step.h"

namespace signorini::problem {

/// Sets the displacement y of the initial state to the equilibrium without friction under the loads of t = 0
/// (initial.static): A y + N λ = f with 0 ≤ λ ⟂ g(y) ≥ 0. Along directions in which nothing holds the body
/// the loads accelerate it, A y + N λ = f − M a with the translation a, so that it starts without vibrations.
/// On entry y has the displacements of the clamps. `load`: null without loads. Collective. Throws UserError
/// if there is no equilibrium, SolverFailure.
void start_in_equilibrium(const step::Stepper& stepper, const fem::Operators& operators,
                          const scene::Scene& scene, const step::SceneLoad* load, Vec y);

} // namespace signorini::problem
