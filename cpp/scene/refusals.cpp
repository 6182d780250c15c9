// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/key_reference.h"
#include <algorithm>
#include <cctype>
#include <fmt/format.h>

namespace signorini::scene {
namespace {

/// An effect outside the model, with the words and keys by which scenes request the effect.
struct Refusal {
  const char* effect;                 ///< name of the effect
  const char* instead;                ///< what the model has instead, as text for users
  std::vector<std::string> words;     ///< words that request the effect in a key's last name or value
  std::vector<std::string> keys = {}; ///< whole keys that request the effect
};

/// Table of all effects outside the model.
const std::vector<Refusal>& refusals() {
  static const std::vector<Refusal> all{
      {"contact of a surface with itself, and bodies that are tied",
       "give two surfaces without common nodes as contact.on and contact.against",
       {"self", "tie"}},
      {"penalty or compliance of contact",
       "contact is the condition gap >= 0, without parameters",
       {"penalty", "compliance"},
       {"contact.stiffness", "contact.damping"}},
      {"a prescribed coefficient of restitution",
       "restitution follows from the body's vibration, material.viscosity and material.prony",
       {"restitution"}},
      {"adhesion", "contact forces only push", {"adhesion", "adhesive", "cohesion", "cohesive", "glue"}},
      {"large rotations and strains",
       "strain is linear, obstacles are linearised about the undeformed body",
       {"large", "finite", "nonlinear", "nlgeom", "kinematics", "corotational", "lagrangian"}},
      {"nonlinear materials",
       "materials are linear: young, poisson, viscosity and prony",
       {"hyperelastic", "hookean", "neohookean", "mooney", "ogden", "yield", "plastic", "plasticity",
        "hardening", "damage", "fracture"},
       {"material.model", "material.law", "material.type"}},
      {"anisotropic materials", "materials are isotropic", {"orthotropic", "anisotropic", "fibre", "fiber"}},
      {"heat", "there is no temperature", {"temperature", "thermal", "heat", "conductivity", "wlf"}},
      {"single springs",
       "springs act per area of a surface: [[foundation]]",
       {"spring", "springs", "winkler"}}};
  return all;
}

/// An effect of the model that scenes request under names which are not its keys.
struct Synonym {
  const char* instead;                ///< the effect's own key, as text for users
  std::vector<std::string> words;     ///< words of a key's last name or value
  std::vector<std::string> keys = {}; ///< whole keys
  const char* own = "";               ///< the effect's own key if it has one of the words
};

/// Table of names that other programs and textbooks have for keys of scenes.
const std::vector<Synonym>& synonyms() {
  static const std::vector<Synonym> all{
      {"a branch has g and k, fractions of the instantaneous shear and bulk modulus, and time in s",
       {},
       {"material.prony.tau", "material.prony.tau_i", "material.prony.t", "material.prony.g_i",
        "material.prony.k_i", "material.prony.shear", "material.prony.bulk", "material.prony.modulus",
        "material.prony.young", "material.prony.relaxation_time"}},
      {"give relaxation as material.prony = [{ g = 0.3, k = 0.0, time = 1e-3 }], with a table for each "
       "branch",
       {"relaxation", "maxwell", "wiechert", "viscoelastic"},
       {"material.prony_series", "material.g", "material.k", "material.tau", "prony"}},
      {"give damping as material.viscosity = { bulk, shear }, material.rayleigh = { alpha, beta } or "
       "material.prony",
       {},
       {"material.damping", "damping"}},
      {"give the model of a body in the plane as mesh.model = \"plane-strain\", \"plane-stress\" or "
       "\"axisymmetric\"",
       {"axisymmetric", "axisymmetry", "axisym"},
       {"mesh.plane_stress", "material.plane_stress", "plane_stress", "mesh.plane_strain",
        "material.plane_strain", "plane_strain"}},
      {"give elasticity as material.young and material.poisson",
       {},
       {"material.mu", "material.lambda", "material.lame", "material.shear_modulus"}},
      {"give contact of two parts of the mesh as contact.on and contact.against, groups of their boundaries",
       {"master", "bodies"},
       {"contact.with", "contact.target", "contact.between", "contact.obstacle.young",
        "contact.obstacle.poisson", "contact.obstacle.material"}},
      {"give the mass of an obstacle that moves freely as contact.obstacle.mass, in kg",
       {"impactor", "hammer"},
       {"contact.obstacle.density", "contact.obstacle.weight"},
       "contact.obstacle.mass"},
      {"give Coulomb friction as contact.friction, one coefficient for stick and slip: a number or an "
       "expression in x, y, z, t",
       {"friction", "frictional", "coulomb", "mu", "stick", "slip"},
       {"contact.friction.coefficient", "contact.friction.value", "contact.friction.static",
        "contact.friction.kinetic", "contact.friction.dynamic"},
       "contact.friction"},
      {"give Tresca friction as contact.friction = { bound = \"2e5\" }, the largest tangential traction in "
       "Pa",
       {"tresca"},
       {"contact.bound", "contact.friction.stress", "contact.friction.traction"}},
      {"give the motion of a belt or of a roller's surface as contact.obstacle.surface_velocity in m/s",
       {"belt", "conveyor", "spin"},
       {"contact.surface_velocity", "contact.obstacle.angular_velocity", "contact.obstacle.omega",
        "contact.obstacle.rotation", "contact.obstacle.surface_speed"}},
      {"forces of a body in the plane are per metre of thickness, so divide loads in N by the thickness. A "
       "thin plate has mesh.model = \"plane-stress\"",
       {"thickness"}}};
  return all;
}

/// Splits a name into words, in lower case, at characters other than letters and digits.
std::vector<std::string> words(std::string_view name) {
  std::vector<std::string> found(1);
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c)))
      found.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else
      found.emplace_back();
  return found;
}

} // namespace

std::string refusal(std::string_view key, std::string_view value) {
  const auto named = words(key.substr(key.rfind('.') + 1)), valued = words(value);
  const bool quantity = named.front() == "of"; // its values are no keys
  const auto requests = [&](const auto& one) {
    return std::ranges::find(one.keys, key) != one.keys.end() ||
           std::ranges::find_first_of(named, one.words) != named.end() ||
           std::ranges::find_first_of(valued, one.words) != valued.end();
  };
  for (const Synonym& one : synonyms())
    if (key != one.own && !quantity && requests(one))
      return fmt::format("unknown; {}", one.instead);
  for (const Refusal& one : refusals())
    if (requests(one))
      return fmt::format("not in this model: {}; {}; see \"Not in this model\" in docs/modelling.md",
                         one.effect, one.instead);
  return {};
}

std::vector<std::string> refused_effects() {
  std::vector<std::string> all;
  for (const Refusal& one : refusals())
    all.emplace_back(one.effect);
  return all;
}

} // namespace signorini::scene
