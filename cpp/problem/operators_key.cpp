// SPDX-License-Identifier: GPL-3.0-or-later
#include "problem/operators_key.h"
#include <fmt/format.h>

namespace signorini::problem {

bool has_given_control(const scene::Scene& scene) { return scene.control && !scene::rests(*scene.control); }

bool has_densities(const scene::Scene& scene, step::Stepper::Needs needs) {
  const bool optimal_control = needs.derivatives || scene.objective.has_value();
  const bool controlled = optimal_control ? scene.control.has_value() : has_given_control(scene);
  return (scene.load && scene.load->body) ||
         (controlled && !scene.control->on && scene.control->space == scene::ControlValues::nodal) ||
         (optimal_control && scene.objective && !scene.objective->on && !scene.objective->obstacle);
}

std::string operators_key(const scene::Scene& scene, step::Stepper::Needs needs) {
  scene::Scene body = scene;
  body.load = {};
  body.initial = {};
  body.control = {};
  body.objective = {};
  body.scenarios = {};
  body.unknowns = {};
  body.measurements = {};
  body.optimizer = {};
  body.check = {};
  body.exact = {};
  body.run = {};
  body.output = {};
  body.trajectory = {};
  for (scene::Contact& contact : body.contacts) {
    if (contact.obstacle && !contact.rigid)
      contact.obstacle = scene::HalfSpace{};
    if (contact.friction != scene::Expression(0))
      contact.friction = 1.0;
    if (contact.bound)
      contact.bound = scene::FrictionBound{1.0};
    contact.surface_velocity = {};
    contact.initial = {};
    if (contact.rigid) {
      contact.rigid->velocity = {};
      contact.rigid->force = {};
    }
  }
  return fmt::format("{}\n{} {} {} {}", scene::echo(body, 3), has_densities(scene, needs), needs.derivatives,
                     needs.passes, needs.iterative);
}

} // namespace signorini::problem
