// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/error.h"
#include "scene/rules.h"
#include <fmt/format.h>

namespace signorini::scene {

void require_rules(Reader& in, const Mesh& mesh, const Scene&) {
  const std::optional<MeshFormat> format = mesh_format(mesh.file);
  if (!format)
    in.fail("file",
            fmt::format("found \"{}\"; expected a file that ends in {}", in.text("file"), mesh_extensions()));
  const bool meshed = mesh.meshed(), shape = format == MeshFormat::shape;
  if (mesh.size && meshed)
    in.fail("size", "has no effect on a mesh; use it with a geometry, such as a .geo");
  if (in.has("scale") && (meshed || mesh.size || shape))
    in.fail("scale", fmt::format("has no effect {}; use it with a .geo that sets its own sizes",
                                 mesh.size ? "beside mesh.size"
                                 : shape   ? "on a CAD file, which has no sizes"
                                           : "on a mesh"));
  if (shape && !mesh.size)
    in.fail("size", "missing: a CAD file has no element sizes; give one");
  if (in.has("unit") && names_its_unit(mesh.file))
    in.fail("unit", "has no effect on this CAD file, which names its unit; remove it");
  if (in.has("split") && shape)
    in.fail("split", "has no effect on a CAD file, which is meshed with triangles or tetrahedra; remove it");
}

std::string excess_of_fractions(const Material& material) {
  for (const auto& [name, fraction] : {std::pair{'g', &Branch::g}, {'k', &Branch::k}}) {
    double sum = 0;
    for (const Branch& branch : material.prony)
      sum += branch.*fraction;
    if (!(sum < Material::most_relaxed))
      return fmt::format(
          "fractions {} that add up to {:.10g}; expected a sum below {}, so that a long-term modulus remains",
          name, sum, Material::most_relaxed);
  }
  return {};
}

void require_rules(Reader& in, const Branch& branch, const Scene&) {
  if (branch.g + branch.k > 0)
    return;
  in.finish(); // reports a misspelt key, the likeliest reason
  in.fail("", "found neither g nor k above 0, so that the branch has no effect; give one of them");
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
  if (const std::string excess = excess_of_fractions(material); !excess.empty())
    in.fail("prony", "found " + excess);
  if (in.has("moduli") && !material.relaxes())
    in.fail("moduli", "has no effect without prony; give a Prony series, or remove moduli");
  require_model(in, material, scene);
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
  const auto acts = [](const auto& table) { return table->normal + table->tangential > 0; };
  if (foundation.stiffness && !acts(foundation.stiffness))
    in.fail("stiffness", "found no number above 0; give normal or tangential, or remove it");
  if (foundation.damping && !acts(foundation.damping))
    in.fail("damping", "found no number above 0; give normal or tangential, or remove it");
  if (foundation.absorbing && foundation.damping)
    in.fail("damping", "found together with absorbing = true, which sets the dashpots; remove one of them");
}

std::string foundation_key(std::size_t i) { return fmt::format("foundation[{}]", i); }

} // namespace signorini::scene
