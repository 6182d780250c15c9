// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include "step/step.h"
#include <string>

namespace signorini::problem {

/// Whether a simulation of the scene applies a control.
bool has_given_control(const scene::Scene& scene);

/// Whether a load, control or objective is a density in the body, which needs the matrix W.
bool has_densities(const scene::Scene& scene, step::Stepper::Needs needs);

/// Text of all of a scene that determines operators, D and its solver: problems of scenes with the same text
/// may share them.
std::string operators_key(const scene::Scene& scene, step::Stepper::Needs needs);

} // namespace signorini::problem
