// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/error.h"
#include "scene/rules.h"
#include <fmt/format.h>

namespace signorini::scene {

Viscosity Material::total_viscosity() const {
  Viscosity total = viscosity.value_or(Viscosity{});
  if (rayleigh) {
    total.bulk += rayleigh->beta * young / (3 * (1 - 2 * poisson));
    total.shear += rayleigh->beta * young / (2 * (1 + poisson));
  }
  return total;
}

void require_rules(Reader& in, const Mesh& mesh, const Scene&) {
  const std::string extension = mesh.file.extension().string();
  const bool meshed = extension == ".msh";
  if (extension != ".geo" && !meshed)
    in.fail("file", fmt::format("found \"{}\"; expected a file that ends in .geo or .msh", in.text("file")));
  if (mesh.size && meshed)
    in.fail("size", "has no effect on a .msh, which is meshed already; use it with a .geo");
  if (in.has("scale") && (meshed || mesh.size))
    in.fail("scale", fmt::format("has no effect {}; use it with a .geo that sets its own sizes",
                                 mesh.size ? "beside mesh.size" : "on a .msh, which is meshed already"));
}

void require_rules(Reader& in, const Material& material, const Scene& scene) {
  if (in.one_of_several())
    in.require("on");
  else if (material.on)
    in.fail("on", "has no effect in [material], which applies to the whole body; use it in tables "
                  "[[material]]");
  for (std::size_t i = 0; i + 1 < scene.materials.size(); ++i)
    if (scene.materials[i].on == material.on)
      in.fail("on", fmt::format("found \"{}\", which is the group of material[{}]; choose another group",
                                *material.on, i));
}

void require_rules(Reader& in, const Foundation& foundation, const Scene& scene) {
  for (std::size_t i = 0; i + 1 < scene.foundations.size(); ++i)
    if (scene.foundations[i].on == foundation.on)
      in.fail("on", fmt::format("found \"{}\", which is the group of {} too; give a group one foundation",
                                foundation.on, foundation_key(i)));
  if (!foundation.stiffness && !foundation.damping && !foundation.absorbing) {
    in.finish(); // reports a misspelt key, the likeliest reason
    in.fail("", "found none of stiffness, damping, absorbing; give at least one");
  }
  if (foundation.absorbing && foundation.damping)
    in.fail("damping", "found together with absorbing = true, which sets the dashpots; remove one of them");
}

std::string foundation_key(std::size_t i) { return fmt::format("foundation[{}]", i); }

} // namespace signorini::scene
