// SPDX-License-Identifier: GPL-3.0-or-later
#include "fixtures.h"
#include "scene/key_reference.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <fstream>
#include <sstream>

using namespace signorini;
using Catch::Matchers::ContainsSubstring;

TEST_CASE("what the model lacks is refused by its name", "[scene]") {
  for (const auto& [settings, said] : std::vector<std::pair<std::vector<std::string>, const char*>>{
           {{"contact.tie=true"}, "contact.tie: not in this model: contact of a surface with itself"},
           {{"contact.obstacle.shape=\"self-contact\""},
            "found \"self-contact\", not in this model: contact of a surface with itself"},
           {{"large_rotation=true"}, "large_rotation: not in this model: large rotations and strains;"},
           {{"material.model=\"neo-hookean\""}, "material.model: not in this model: nonlinear materials;"}})
    CHECK_THROWS_WITH(test::parse(test::source("tests/data/block.toml"), settings),
                      ContainsSubstring(said) &&
                          ContainsSubstring("\"Not in this model\" in docs/modelling.md"));
  // A misspelt key is one still, and a text is free.
  CHECK_THROWS_WITH(test::parse(test::source("tests/data/block.toml"), {"contact.obstakle=1"}),
                    ContainsSubstring("contact.obstakle: unknown key, did you mean \"obstacle\"?"));
  CHECK_THROWS_WITH(test::parse(test::source("tests/data/block.toml"), {"output.title=\"large friction\""}),
                    ContainsSubstring("output.title: unknown key"));
}

TEST_CASE("a key under another name is refused by its own name", "[scene]") {
  for (const auto& [setting, said] : std::vector<std::pair<std::string, const char*>>{
           {"material.prony_series=[]", "material.prony_series: unknown; give relaxation as material.prony"},
           {"material.relaxation={ time = 1 }", "material.relaxation: unknown; give relaxation as"},
           {"material.model=\"maxwell\"", "material.model: unknown; give relaxation as"},
           {"material.tau=1e-3", "material.tau: unknown; give relaxation as"},
           {"material.g=0.3", "material.g: unknown; give relaxation as"},
           {"material.prony=[{ g = 0.3, tau = 1e-3 }]",
            "material.prony[0].tau: unknown; a branch has g and k"},
           {"material.damping=0.1", "material.damping: unknown; give damping as material.viscosity"},
           {"mesh.plane_stress=true",
            "mesh.plane_stress: unknown; give the model of a body in the plane as mesh.model"},
           {"axisymmetric=true",
            "axisymmetric: unknown; give the model of a body in the plane as mesh.model"},
           {"material.model=\"axisymmetric\"",
            "material.model: unknown; give the model of a body in the plane"},
           {"contact.master=\"top\"", "contact.master: unknown; give contact of two parts of the mesh as"},
           {"contact.mu=0.3",
            "contact.mu: unknown; give Coulomb friction as contact.friction, one coefficient"},
           {"contact.Friction_Coefficient=0.3",
            "contact.Friction_Coefficient: unknown; give Coulomb friction as contact.friction"},
           {"friction.coefficient=0.3", "friction: unknown; give Coulomb friction as contact.friction"},
           {"material.friction=0.3", "material.friction: unknown; give Coulomb friction as contact.friction"},
           {"contact.obstacle.mu=0.3",
            "contact.obstacle.mu: unknown; give Coulomb friction as contact.friction"},
           {"contact.law=\"coulomb\"", "contact.law: unknown; give Coulomb friction as contact.friction"},
           {"contact.static_friction=0.3",
            "contact.static_friction: unknown; give Coulomb friction as contact.friction, one coefficient"},
           {"contact.friction={ static = 0.4, kinetic = 0.3 }",
            ": unknown; give Coulomb friction as contact.friction, one coefficient for stick and slip"},
           {"contact.tresca=2e5",
            "contact.tresca: unknown; give Tresca friction as contact.friction = { bound = \"2e5\" }, the "
            "largest tangential traction in Pa"},
           {"contact.law=\"Tresca\"", "contact.law: unknown; give Tresca friction as contact.friction = {"},
           {"contact.bound=2e5",
            "contact.bound: unknown; give Tresca friction as contact.friction = { bound"},
           {"contact.friction={ traction = 2e5 }",
            "contact.friction.traction: unknown; give Tresca friction as contact.friction = { bound"},
           {"contact.surface_velocity=[\"1\", \"0\"]",
            "contact.surface_velocity: unknown; give the motion of a belt or of a roller's surface as"},
           {"contact.obstacle.omega=3",
            "contact.obstacle.omega: unknown; give the motion of a belt or of a roller's surface as"},
           {"contact.obstacle.density=7800",
            "contact.obstacle.density: unknown; give the mass of an obstacle"},
           {"material.mu=4e7",
            "material.mu: unknown; give elasticity as material.young and material.poisson"},
           {"material.thickness=0.01",
            "material.thickness: unknown; forces of a body in the plane are per metre"}})
    CHECK_THROWS_WITH(test::parse(test::source("tests/data/block.toml"), {setting}), ContainsSubstring(said));
}

TEST_CASE("no key that scenes have is refused", "[scene]") {
  for (const scene::KeyLine& key : scene::keys())
    for (std::size_t end = 0; end != std::string::npos;) {
      end = key.name.find('.', end + 1);
      CHECK(scene::refusal(key.name.substr(0, end)).empty());
    }
}

TEST_CASE("the documentation lists what is refused", "[scene]") {
  std::ostringstream page;
  page << std::ifstream(test::source("docs/modelling.md")).rdbuf();
  const std::string text = page.str(), heading = "## Not in this model\n";
  REQUIRE(text.find(heading) != std::string::npos);
  const std::size_t start = text.find(heading) + heading.size();
  const std::string section = text.substr(start, text.find("\n## ", start) - start);
  for (const std::string& effect : scene::refused_effects())
    CHECK_THAT(section, ContainsSubstring("- **" + effect + "**"));
  std::size_t rows = 0;
  for (std::size_t at = section.find("- **"); at != std::string::npos; at = section.find("- **", at + 1))
    ++rows;
  CHECK(rows == scene::refused_effects().size());
}
