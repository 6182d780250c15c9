// SPDX-License-Identifier: GPL-3.0-or-later
// Rules that depend on the dimension of the mesh.
#include "base/error.h"
#include "base/overloads.h"
#include "base/text.h"
#include "scene/expression.h"
#include "scene/rules.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::scene {

namespace {

/// Checks that the vectors of a scene have as many components as the mesh has dimensions.
class Dimension {
public:
  Dimension(const Scene& scene, int dim) : scene_(scene), dim_(dim) {}

  void vector(std::size_t size, const std::string& key, bool one_allowed = false) const {
    if (size != static_cast<std::size_t>(dim_) && !(one_allowed && size == 1))
      throw UserError(fmt::format("{}: found {} components; expected {}, since the mesh is {}-dimensional",
                                  where(key), size, dim_, dim_));
  }
  template <class V>
  void vector(const std::optional<V>& given, const std::string& key, bool one_allowed = false) const {
    if (given)
      vector(given->size(), key, one_allowed);
  }
  void acting(const std::optional<std::vector<Component>>& given, const std::string& key) const {
    std::vector<std::string> allowed = all_names<Component>();
    allowed.resize(static_cast<std::size_t>(dim_));
    for (Component component : given.value_or(components(dim_)))
      if (static_cast<int>(component) >= dim_)
        throw UserError(fmt::format("{}: found \"{}\"; choices: {}, since the mesh is {}-dimensional",
                                    where(key), name(component), list(allowed), dim_));
  }
  /// Checks that an axis of rotation is given in 3D and absent in 2D, where it can only be z.
  void axis(const std::optional<Component>& given, const std::string& key) const {
    if (given.has_value() == (dim_ == 2))
      throw UserError(fmt::format("{}: found {}; expected {}, since the mesh is {}-dimensional", where(key),
                                  given ? name(*given) : "none",
                                  dim_ == 2 ? "none (the angle is in the plane)" : "an axis", dim_));
  }
  void plane_model() const {
    if (scene_.mesh.model && dim_ != 2)
      throw UserError(
          fmt::format("{}: found \"{}\" with a mesh in space; it applies to meshes in the plane, so "
                      "remove it",
                      where("mesh.model"), name(*scene_.mesh.model)));
  }
  void obstacle(const Obstacle& shape, const std::string& key) const {
    std::visit(Overloads{[&](const HalfSpace& plane) {
                           vector(plane.point.size(), key + "point");
                           vector(plane.normal.size(), key + "normal");
                         },
                         [&](const Ball& ball) { vector(ball.center.size(), key + "center"); },
                         [&](const Cylinder& cylinder) { vector(cylinder.point.size(), key + "point"); },
                         [](const SignedDistance&) {}}, // its expression has x, y, z in any dimension
               shape);
  }

  void rigid_body(const RigidBody& body, const std::string& key) const {
    const auto given = [&](const std::vector<double>& values, const char* name, bool one_allowed) {
      if (!values.empty())
        vector(values.size(), key + name, one_allowed);
    };
    given(body.velocity, "velocity", false);
    given(body.mass_center, "mass_center", false);
    given(body.stiffness, "stiffness", true);
    given(body.damping, "damping", true);
    vector(body.force, key + "force");
    acting(body.components, key + "components");
    const std::size_t turns = dim_ == 2 ? 1 : 3;
    if (!body.inertia.empty() && body.inertia.size() != turns)
      throw UserError(fmt::format("{}: found {} numbers; expected {}, since the mesh is {}-dimensional",
                                  where(key + "inertia"), body.inertia.size(), turns, dim_));
  }

private:
  /// Key, preceded by "--set" or by the name of the scene file, whichever gave the key.
  [[nodiscard]] std::string where(const std::string& key) const {
    const std::string plain = without_numbers(key);
    const auto gave = [&](const std::string& set) { return plain == set || plain.starts_with(set + "."); };
    return (std::ranges::any_of(scene_.given, gave) ? "--set " : scene_.file.string() + ": ") + key;
  }

  const Scene& scene_;
  int dim_;
};

} // namespace

void require_dimension(const Scene& scene, int dim) {
  const Dimension require(scene, dim);
  require.plane_model();
  for (std::size_t i = 0; i < scene.contacts.size(); ++i) {
    const std::string key = contact_key(scene.contacts, i) + ".obstacle.";
    if (const auto& shape = scene.contacts[i].obstacle)
      require.obstacle(*shape, key);
    require.vector(scene.contacts[i].surface_velocity, key + "surface_velocity");
    if (const auto& body = scene.contacts[i].rigid)
      require.rigid_body(*body, key);
  }
  for (std::size_t i = 0; i < scene.clamps.size(); ++i) {
    const Clamp& clamp = scene.clamps[i];
    require.acting(clamp.components, clamp_key(scene.clamps, i) + ".components");
    if (!clamp.components)
      require.vector(clamp.value, clamp_key(scene.clamps, i) + ".value");
  }
  if (scene.load) {
    require.vector(scene.load->body, "load.body");
    require.vector(scene.load->gravity, "load.gravity");
  }
  for (std::size_t i = 0; scene.load && i < scene.load->tractions.size(); ++i)
    require.vector(scene.load->tractions[i].value.size(), fmt::format("load.traction[{}].value", i));
  for (std::size_t i = 0; scene.load && i < scene.load->points.size(); ++i) {
    require.vector(scene.load->points[i].at.size(), fmt::format("load.point[{}].at", i));
    require.vector(scene.load->points[i].value.size(), fmt::format("load.point[{}].value", i));
  }
  require.vector(scene.initial.displacement, "initial.displacement");
  require.vector(scene.initial.velocity, "initial.velocity");
  if (const auto& control = scene.control) {
    require.acting(control->components, "control.components");
    require.vector(control->initial, "control.initial");
    require.vector(control->lower, "control.lower", true);
    require.vector(control->upper, "control.upper", true);
  }
  if (scene.objective) {
    if (const auto* desired = std::get_if<DesiredControl>(&scene.objective->desired))
      require.vector(desired->control.size(), "objective.desired.control");
    if (const auto* desired = std::get_if<DesiredDisplacement>(&scene.objective->desired))
      require.vector(desired->displacement.size(), "objective.desired.displacement");
  }
  require.vector(scene.check.control, "check.control");
  for (std::size_t i = 0; i < scene.output.probes.size(); ++i)
    require.vector(scene.output.probes[i].point, fmt::format("output.probe[{}].point", i));
  for (std::size_t i = 0; i < scene.unknowns.size(); ++i) {
    const Unknown& unknown = scene.unknowns[i];
    const std::string key = unknown_key(i) + ".component";
    if (unknown.of == Parameter::angle)
      require.axis(unknown.component, key);
    else if (unknown.component)
      require.acting(std::vector{*unknown.component}, key);
  }
  for (std::size_t i = 0; i < scene.measurements.size(); ++i) {
    require.vector(scene.measurements[i].point, measurement_key(i) + ".point");
    if (const auto component = scene.measurements[i].component)
      require.acting(std::vector{*component}, measurement_key(i) + ".component");
  }
  if (scene.exact)
    require.vector(scene.exact->displacement, "exact.displacement");
}

} // namespace signorini::scene
