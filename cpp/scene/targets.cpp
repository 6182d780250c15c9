// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/targets.h"
#include "scene/parameters.h"
#include <stdexcept>

namespace signorini::scene {

std::size_t material_of(const Scene& scene, const Unknown& unknown) {
  for (std::size_t i = 0; i < scene.materials.size(); ++i)
    if (scene.materials.size() == 1 || scene.materials[i].on == unknown.on)
      return i;
  throw std::out_of_range("no material of the scene has this unknown");
}

std::size_t branch_of(const Scene& scene, const Unknown& unknown) {
  const std::size_t count = scene.materials[material_of(scene, unknown)].prony.size();
  const auto number = static_cast<std::size_t>(unknown.branch.value_or(0));
  if (number >= count || (count > 1 && !unknown.branch))
    throw std::out_of_range("no branch of the material has this unknown");
  return number;
}

std::size_t contact_of(const Scene& scene, const Unknown& unknown) {
  for (std::size_t i = 0; i < scene.contacts.size(); ++i)
    if (scene.contacts.size() == 1 || scene.contacts[i].name == unknown.obstacle)
      return i;
  throw std::out_of_range("no obstacle of the scene has this unknown");
}

int obstacle_number(const std::vector<Contact>& contacts, const std::string& name) {
  return static_cast<int>(std::ranges::find(contacts, name, &Contact::name) - contacts.begin());
}

std::size_t foundation_of(const Scene& scene, const Unknown& unknown) {
  for (std::size_t i = 0; i < scene.foundations.size(); ++i)
    if (scene.foundations.size() == 1 || scene.foundations[i].on == unknown.on)
      return i;
  throw std::out_of_range("an unknown of no foundation");
}

double& number_of(Branch& branch, Parameter of) {
  return of == Parameter::prony_g ? branch.g : of == Parameter::prony_k ? branch.k : branch.time;
}

double& number_of(Scene& scene, const Unknown& unknown) {
  if (of_foundation(unknown.of)) {
    Foundation& foundation = scene.foundations[foundation_of(scene, unknown)];
    switch (unknown.of) {
    case Parameter::normal_stiffness:
      return foundation.stiffness.value().normal;
    case Parameter::tangential_stiffness:
      return foundation.stiffness.value().tangential;
    case Parameter::normal_damping:
      return foundation.damping.value().normal;
    default:
      return foundation.damping.value().tangential;
    }
  }
  if (of_rigid_body(unknown.of)) {
    RigidBody& body = scene.contacts[contact_of(scene, unknown)].rigid.value();
    std::vector<double>* numbers = numbers_of(body, unknown.of);
    return numbers ? numbers->at(static_cast<std::size_t>(unknown.component.value_or(Component::x)))
                   : body.mass;
  }
  if (unknown.of == Parameter::height)
    return scene.contacts[contact_of(scene, unknown)].height;
  Material& material = scene.materials[material_of(scene, unknown)];
  switch (unknown.of) {
  case Parameter::young:
    return material.young;
  case Parameter::poisson:
    return material.poisson;
  case Parameter::bulk:
    return material.viscosity.value().bulk;
  case Parameter::shear:
    return material.viscosity.value().shear;
  case Parameter::alpha:
    return material.rayleigh.value().alpha;
  case Parameter::beta:
    return material.rayleigh.value().beta;
  case Parameter::prony_g:
  case Parameter::prony_k:
  case Parameter::prony_time:
    return number_of(material.prony.at(branch_of(scene, unknown)), unknown.of);
  default:
    return material.density;
  }
}

std::vector<double>* numbers_of(RigidBody& body, Parameter of) {
  switch (of) {
  case Parameter::inertia:
    return &body.inertia;
  case Parameter::rigid_velocity:
    return &body.velocity;
  case Parameter::spring_stiffness:
    return &body.stiffness;
  case Parameter::dashpot_damping:
    return &body.damping;
  default:
    return nullptr;
  }
}

} // namespace signorini::scene
