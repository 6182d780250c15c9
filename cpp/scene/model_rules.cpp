// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/expression.h"
#include "scene/parameters.h"
#include "scene/rules.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace signorini::scene {

namespace {

/// Throws UserError unless the radial component of a vector is written as zero. `why`: the reason, as the end
/// of a message.
void require_on_axis(const Reader& in, const char* key, const Components& value, const char* why) {
  if (!vanishes({value.front()}))
    in.fail(key,
            fmt::format("found \"{}\" for x, the radius; expected 0, since {}", value.front().text, why));
}

constexpr const char* centred =
    "in axial symmetry a round obstacle has its centre on the axis. Describe other "
    "shapes by shape = \"signed-distance\"";

/// Whether two numbers with about seven digits are equal.
bool equal(double a, double b) {
  constexpr double digits = 1e-6;
  return std::abs(a - b) <= digits * std::max(std::abs(a), std::abs(b));
}

} // namespace

void require_rules(Reader& in, const HalfSpace& plane, const Scene& scene) {
  if (scene.mesh.axisymmetric() && plane.normal.front() != 0)
    in.fail("normal",
            fmt::format("found {:.6g} for x, the radius; in axial symmetry the normal of a half-space is "
                        "[0, 1] or [0, -1]. For a tube around the axis use a cylinder",
                        plane.normal.front()));
}

void require_rules(Reader& in, const Ball& ball, const Scene& scene) {
  if (scene.mesh.axisymmetric())
    require_on_axis(in, "center", ball.center, centred);
}

void require_model(const Reader& in, const Cylinder& cylinder, const Scene& scene) {
  if (!scene.mesh.axisymmetric())
    return;
  require_on_axis(in, "point", cylinder.point, centred);
  if (Field(cylinder.point, "point", true).depends_on_time())
    in.fail("point",
            "depends on t; in axial symmetry a cylinder is a tube around the axis, whose radius alone can "
            "change");
}

void require_rules(Reader& in, const Load& load, const Scene& scene) {
  if (scene.mesh.axisymmetric() && load.gravity)
    require_on_axis(in, "gravity", *load.gravity, "in axial symmetry gravity acts along the axis y");
}

void require_model(const Reader& in, const Material& material, const Scene& scene) {
  if (scene.mesh.model != PlaneModel::plane_stress)
    return;
  // Otherwise the ratio of the strain across the plate to those in the plane would vary with time.
  const ElasticModuli moduli = material.given();
  if (const auto& viscosity = material.viscosity;
      viscosity && !equal(viscosity->bulk * moduli.shear, viscosity->shear * moduli.bulk))
    in.fail("viscosity",
            fmt::format("found bulk/shear = {:.6g}; in plane stress it must be the elastic K/G = {:.8g}, "
                        "so that the stress across the plate stays zero. For another ratio use a mesh "
                        "in space",
                        viscosity->bulk / viscosity->shear, moduli.bulk / moduli.shear));
  for (std::size_t j = 0; j < material.prony.size(); ++j)
    if (const Branch& branch = material.prony[j]; !equal(branch.g, branch.k))
      in.fail(
          "prony",
          fmt::format("found g = {:.6g} and k = {:.6g} in prony[{}]; in plane stress they must be equal, so "
                      "that the stress across the plate stays zero. For other fractions use a mesh in "
                      "space",
                      branch.g, branch.k, j));
}

void require_model(const Reader& in, const Unknown& unknown, const Scene& scene) {
  if (scene.mesh.axisymmetric()) {
    if (unknown.of == Parameter::angle)
      in.fail("of",
              "found \"angle\"; in axial symmetry an obstacle cannot be tilted, so choose another unknown");
    const bool tube = unknown.of == Parameter::center && !scene.contacts.empty() &&
                      scene.contacts[contact_of(scene, unknown)].meets_cylinder();
    if (tube)
      in.fail("of",
              "found \"center\" of a cylinder; in axial symmetry it is a tube around the axis, of which only "
              "the radius is a parameter");
    const bool field = unknown.of == Parameter::velocity || unknown.of == Parameter::displacement;
    if (field && unknown.component == Component::x)
      in.fail("component",
              "found x, the radius, along which a body of revolution does not move as a whole; use \"y\"");
    if (unknown.of == Parameter::center && unknown.component == Component::x)
      in.fail("component",
              "found x, the radius; in axial symmetry a centre is on the axis, x = 0. Use \"y\"");
  }
  if (scene.mesh.model != PlaneModel::plane_stress)
    return;
  using enum Parameter;
  if (unknown.of == bulk || unknown.of == shear || unknown.of == prony_g || unknown.of == prony_k)
    in.fail("of",
            fmt::format("found \"{}\"; in plane stress the ratio of bulk and shear must stay that of the "
                        "elastic moduli. Choose another unknown, or use a mesh in space",
                        name(unknown.of)));
  if (unknown.of == poisson && std::ranges::any_of(scene.materials, [](const Material& one) {
        return one.viscosity || one.relaxes();
      }))
    in.fail("of",
            "found \"poisson\"; in plane stress it cannot be varied beside viscosity or prony, whose ratio "
            "of bulk and shear follows from it. Choose another unknown, or use a mesh in space");
}

void require_model(const Reader& in, const Measurement& measurement, const Scene& scene) {
  if (scene.mesh.axisymmetric() && measurement.point && measurement.point->front() == 0 &&
      measurement.component == Component::x)
    in.fail("component",
            "found x, the radius, at a point on the axis, which does not move radially; use \"y\"");
  const bool resultant = measurement.of == Quantity::force || measurement.of == Quantity::impulse;
  if (scene.mesh.axisymmetric() && resultant && measurement.component == Component::x)
    in.fail("component",
            fmt::format("found x, the radius, along which the {} around an axis has no resultant; use \"y\"",
                        name(measurement.of)));
}

} // namespace signorini::scene
