// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/reader.h"
#include "scene/rules.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::scene {

void require_rules(Reader& in, const Cylinder& obstacle, const Scene& scene) {
  if (obstacle.point.size() == 3) {
    in.require("axis");
    if (obstacle.axis.size() != 3)
      in.fail("axis",
              fmt::format("found {} components, but point has 3; give 3 components", obstacle.axis.size()));
  } else if (in.has("axis")) {
    in.fail(
        "axis",
        scene.mesh.axisymmetric()
            ? "has no effect in axial symmetry, where a cylinder is around the axis y; remove it"
            : "has no effect in the plane, where a cylinder is a disc; use it with a point of 3 components");
  }
  require_model(in, obstacle, scene);
}

namespace {

/// Checks the keys of an obstacle with mass, those of a table [contact] being `in`.
void require_rules_of_mass(Reader& in, const RigidBody& body, const Contact& contact, const Scene& scene) {
  const Reader table = in.table("obstacle");
  if (moves(contact))
    table.fail("mass",
               "found with an obstacle whose expressions contain t; its motion is either prescribed or "
               "free, so remove one of them");
  if (contact.initial == ContactStart::project)
    in.fail("initial", "found \"project\" with an obstacle that has mass; move the body or the obstacle");
  if (scene.time.automatic())
    table.fail("mass", "found together with time.step = \"auto\", whose choice does not regard the motion of "
                       "the obstacle; give a step length");
  const auto above = [&](const std::vector<double>& values, const char* key, bool zero) {
    for (const double value : values)
      if (!(value > 0 || (zero && value == 0)))
        table.fail(key, fmt::format("found {}; expected numbers {} 0", value, zero ? "at least" : "above"));
  };
  above(body.stiffness, "stiffness", true);
  above(body.damping, "damping", true);
  above(body.inertia, "inertia", false);
  const bool held =
      !body.stiffness.empty() && std::ranges::all_of(body.stiffness, [](double k) { return k > 0; });
  if (body.mass == 0 && (!held || scene.time.scheme == TimeScheme::contact_stabilized))
    table.fail("mass",
               held ? "found 0 with time.scheme \"contact-stabilized\", whose projection needs masses; "
                      "use \"contact-implicit\""
                    : "found 0 without stiffness in every component; give stiffness, or a mass above 0");
  if (!body.mass_center.empty() && body.inertia.empty())
    table.fail("mass_center", "has no effect on an obstacle that does not turn; give inertia");
  if (!body.inertia.empty() && body.mass_center.empty() &&
      std::holds_alternative<SignedDistance>(*contact.obstacle))
    table.fail("inertia", "found without the point about which the obstacle turns; give mass_center");
  if (!scene.mesh.axisymmetric())
    return;
  if (!body.inertia.empty())
    table.fail("inertia", "found in axial symmetry, where obstacles move along the axis alone; remove it");
  if (body.components && std::ranges::find(*body.components, Component::x) != body.components->end())
    table.fail("components",
               "found \"x\", the radius, along which an obstacle around the axis cannot move; use "
               "[\"y\"]");
}

} // namespace

namespace {

/// Checks the keys of contact with another part of the body.
void require_rules_of_parts(const Reader& in, const Contact& contact, const Scene& scene) {
  if (contact.obstacle)
    in.fail("against", "found together with obstacle; remove one of them, or add a table [[contact]]");
  if (contact.on == *contact.against)
    in.fail("against", "found the group `on`; a surface in contact with itself is not modelled, so give "
                       "groups of two surfaces");
  if (scene.time.automatic())
    in.fail("against",
            "found together with time.step = \"auto\", whose choice does not regard a second body; "
            "give a step length");
  if (scene.mesh.degree == 2 && contact.mass != ContactMass::consistent)
    in.fail("mass", "found a massless surface with contact.against and mesh.degree = 2, where constraints "
                    "share nodes; set mass to \"consistent\", or mesh.degree to 1");
}

} // namespace

void require_rules(Reader& in, const Contact& contact, const Scene& scene) {
  if (contact.against)
    require_rules_of_parts(in, contact, scene);
  else
    for (const char* key : {"slave", "height"})
      if (in.has(key))
        in.fail(key, "has no effect with an obstacle; use it with contact.against");
  if (contact.massless() && scene.time.scheme == TimeScheme::contact_stabilized)
    in.fail("mass", "found \"massless\" with time.scheme \"contact-stabilized\", whose projection needs the "
                    "mass of contact nodes; set mass to \"consistent\"");
  if (contact.mass == ContactMass::massless_tangential) {
    if (scene.time.scheme != TimeScheme::contact_stabilized)
      in.fail("mass", "found \"massless-tangential\" with time.scheme \"contact-implicit\", whose normal "
                      "forces alternate too; set time.scheme to \"contact-stabilized\"");
    if (!contact.frictional())
      in.fail("mass", "found \"massless-tangential\" without friction, where nothing acts along the "
                      "obstacle; give contact.friction");
  }
  if (contact.frictional() && scene.time.automatic())
    in.fail("friction",
            "found together with time.step = \"auto\", whose error estimates do not include slip; "
            "give a step length");
  if (contact.frictional() && moves(contact) && std::holds_alternative<SignedDistance>(*contact.obstacle))
    in.fail("friction", "found with a signed distance that moves, whose motion along the surface is not "
                        "defined; use another shape, or obstacle.surface_velocity of one at rest");
  if (contact.rigid)
    require_rules_of_mass(in, *contact.rigid, contact, scene);
  if (contact.surface_velocity && !contact.frictional())
    in.table("obstacle").fail("surface_velocity", "has no effect without friction; give contact.friction");
}

} // namespace signorini::scene
