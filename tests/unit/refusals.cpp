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
           {{"contact.friction=0.3"}, "contact.friction: not in this model: friction;"},
           {{"contact.friction={ bound = \"2e5\" }"}, "contact.friction: not in this model: friction;"},
           {{"contact.Friction_Coefficient=0.3"}, "not in this model: friction;"},
           {{"friction.coefficient=0.3"}, "friction: not in this model: friction;"},
           {{"contact.law=\"coulomb\""}, "contact.law: not in this model: friction;"},
           {{"contact={ on = \"bottom\", against = \"top\" }"},
            "contact.against: not in this model: contact between"},
           {{"contact.obstacle={ shape = \"half-space\", mass = 2 }"},
            "contact.obstacle.mass: not in this model: obstacles that move freely;"},
           {{"contact.obstacle.shape=\"self-contact\""},
            "found \"self-contact\", not in this model: contact between"},
           {{"large_rotation=true"}, "large_rotation: not in this model: large rotations and strains;"},
           {{"material.model=\"neo-hookean\""}, "material.model: not in this model: nonlinear materials;"},
           {{"material.prony=[{ g = 0.3, time = 1e-3 }]"}, "not in this model: relaxation;"},
           {{"mesh.model=\"axisymmetric\""}, "not in this model: plane stress and axial symmetry;"}})
    CHECK_THROWS_WITH(test::parse(test::source("tests/data/block.toml"), settings),
                      ContainsSubstring(said) &&
                          ContainsSubstring("\"Not in this model\" in docs/modelling.md"));
  // A misspelt key is one still, and a text is free.
  CHECK_THROWS_WITH(test::parse(test::source("tests/data/block.toml"), {"contact.obstakle=1"}),
                    ContainsSubstring("contact.obstakle: unknown key, did you mean \"obstacle\"?"));
  CHECK_THROWS_WITH(test::parse(test::source("tests/data/block.toml"), {"output.title=\"large friction\""}),
                    ContainsSubstring("output.title: unknown key"));
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
