// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/error.h"
#include "fixtures.h"
#include "scene/compatibility.h"
#include "scene/parameters.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>

using namespace signorini;
using Catch::Matchers::ContainsSubstring;

namespace {

const char* const series = "material.prony=[{ g = 0.3, k = 0.1, time = 1e-3 }, { g = 0.2, time = 1e-2 }]";

scene::Material rubber() {
  scene::Material material;
  material.density = 1000;
  material.young = 1e7;
  material.poisson = 0.45;
  material.prony = {{0.3, 0.1, 1e-3}, {0.2, 0.05, 1e-2}};
  return material;
}

void require_near(const scene::ElasticModuli& found, const scene::ElasticModuli& expected,
                  double tolerance = 1e-13) {
  CHECK(std::abs(found.bulk / expected.bulk - 1) < tolerance);
  CHECK(std::abs(found.shear / expected.shear - 1) < tolerance);
}

scene::Scene block(const std::vector<std::string>& overrides) {
  return test::parse(test::source("tests/data/block.toml"), overrides);
}

} // namespace

TEST_CASE("instantaneous and long-term moduli follow from each other", "[scene]") {
  const scene::Material material = rubber();
  const scene::ElasticModuli at_once = material.instantaneous(), relaxed = material.long_term();
  require_near(at_once, {1e7 / 0.3, 1e7 / 2.9});
  require_near(relaxed, {0.85 * at_once.bulk, 0.5 * at_once.shear});
  CHECK(std::abs(at_once.young() / 1e7 - 1) < 1e-13);
  CHECK(std::abs(at_once.poisson() / 0.45 - 1) < 1e-13);
  scene::Material other = material;
  other.young = relaxed.young();
  other.poisson = relaxed.poisson();
  other.moduli = scene::Moduli::long_term;
  require_near(other.long_term(), relaxed);
  require_near(other.instantaneous(), at_once);
  require_near(other.during_step(5e-3), material.during_step(5e-3));
  const scene::ElasticConstants own = material.instantaneous_constants(),
                                others = other.instantaneous_constants();
  CHECK((own.young == 1e7 && own.poisson == 0.45));
  CHECK((std::abs(others.young / 1e7 - 1) < 1e-13 && std::abs(others.poisson / 0.45 - 1) < 1e-13));
}

TEST_CASE("a step meets moduli between the instantaneous and the long-term ones", "[scene]") {
  const scene::Material material = rubber();
  require_near(material.during_step(1e-12), material.instantaneous(), 1e-8);
  require_near(material.during_step(1e6), material.long_term(), 1e-7);
  const scene::ElasticModuli middle = material.during_step(2e-3); // the gains are 1/2 and 10/11
  const auto [bulk, shear] = material.instantaneous();
  require_near(middle, {(0.85 + 0.1 / 2 + 0.05 * 10 / 11) * bulk, (0.5 + 0.3 / 2 + 0.2 * 10 / 11) * shear});
  const auto short_step = scene::branch_step(1e-12, 1e-3), long_step = scene::branch_step(1e6, 1e-3),
             equal = scene::branch_step(2e-3, 1e-3);
  CHECK((std::abs(short_step.gain - 1) < 1e-8 && std::abs(short_step.decay - 1) < 1e-8));
  CHECK((std::abs(long_step.gain) < 1e-8 && std::abs(long_step.decay + 1) < 1e-8));
  CHECK((equal.gain == 0.5 && equal.decay == 0));
}

TEST_CASE("a material without branches has exactly its own constants", "[scene]") {
  scene::Material material = rubber();
  material.prony.clear();
  material.rayleigh = scene::Rayleigh{0.1, 0.7};
  material.viscosity = scene::Viscosity{3.3, 7.7};
  const scene::ElasticModuli given = material.given();
  for (const scene::ElasticModuli& same :
       {material.instantaneous(), material.long_term(), material.during_step(1e-3)})
    CHECK((same.bulk == given.bulk && same.shear == given.shear));
  const scene::ElasticConstants own = material.instantaneous_constants();
  CHECK((own.young == 1e7 && own.poisson == 0.45));
  CHECK(material.total_viscosity().bulk == 3.3 + 0.7 * 1e7 / (3 * (1 - 2 * 0.45)));
  CHECK(material.total_viscosity().shear == 7.7 + 0.7 * 1e7 / (2 * (1 + 0.45)));
}

TEST_CASE("stiffness damping of a material that relaxes has the long-term moduli", "[scene]") {
  scene::Material material = rubber();
  material.moduli = GENERATE(scene::Moduli::instantaneous, scene::Moduli::long_term);
  material.rayleigh = scene::Rayleigh{0, 0.7};
  material.viscosity = scene::Viscosity{3.3, 7.7};
  const auto [bulk, shear] = material.long_term();
  const scene::Viscosity found = material.total_viscosity();
  require_near({found.bulk, found.shear}, {3.3 + 0.7 * bulk, 7.7 + 0.7 * shear});
}

TEST_CASE("a Prony series is read, overridden and echoed", "[scene]") {
  const scene::Scene scene = block({series, "material.moduli=long-term"});
  const scene::Material& material = scene.materials.front();
  REQUIRE(material.prony.size() == 2);
  CHECK((material.prony[0].g == 0.3 && material.prony[0].k == 0.1 && material.prony[0].time == 1e-3));
  CHECK((material.prony[1].g == 0.2 && material.prony[1].k == 0 && material.prony[1].time == 1e-2));
  CHECK(material.moduli == scene::Moduli::long_term);
  const std::string echo = scene::echo(scene, 2);
  CHECK_THAT(echo,
             ContainsSubstring("prony = [{ g = 0.3, k = 0.1, time = 0.001 }, { g = 0.2, k = 0.0, time = "
                               "0.01 }]\nmoduli = \"long-term\"\n"));
  CHECK(scene::echo(scene::parse(echo, scene.file), 2) == echo);
  const std::string changed = scene::echo(block({series, "material.prony.1.g=0.25"}), 2),
                    instantaneous = scene::echo(block({series}), 2);
  CHECK_THAT(changed, ContainsSubstring("{ g = 0.25, k = 0.0, time = 0.01 }]\nmoduli = \"instantaneous\"\n"));
  CHECK(scene::difference(instantaneous, changed).second == "material.prony[1].g = 0.25");
  CHECK(scene::difference(instantaneous, echo).second == "material.moduli = \"long-term\"");
  const std::string without = scene::echo(block({"material.prony=[]"}), 2);
  for (const char* key : {"prony", "moduli"})
    CHECK(without.find(key) == std::string::npos);
  CHECK_FALSE(block({}).relaxes());
  const scene::Scene parts = test::parse(test::source("tests/data/two-materials.toml"),
                                         {"material.1.prony=[{ k = 0.5, time = 2 }]"});
  CHECK((parts.relaxes() && !parts.materials[0].relaxes() && parts.materials[1].prony[0].k == 0.5));
}

TEST_CASE("a fit stays where a long-term modulus remains", "[scene]") {
  const scene::Scene scene = test::parse(
      test::source("tests/data/parameters.toml"),
      {series, "unknown=[{ of = \"prony.g\", branch = 0 }, { of = \"prony.g\", branch = 1 }, { of = "
               "\"prony.k\", branch = 1 }, { of = \"prony.time\", branch = 0 }]"});
  CHECK(scene::start_values(scene) == std::vector{0.3, 0.2, 0.0, 1e-3});
  std::vector<std::string> names, units;
  std::vector<bool> logarithmic;
  for (const scene::Unknown& unknown : scene.unknowns) {
    names.push_back(unknown.name);
    units.push_back(scene::unit(scene, unknown, 2));
    logarithmic.push_back(unknown.logarithmic());
  }
  CHECK(names == std::vector<std::string>{"prony.g 0", "prony.g 1", "prony.k 1", "prony.time 0"});
  CHECK(units == std::vector<std::string>{"", "", "", "s"});
  CHECK(logarithmic == std::vector{false, false, false, true});
  const auto at = [&](const std::vector<double>& values) { return scene::with_values(scene, values); };
  const std::vector<scene::Branch> prony = at({0.4, 0.5, 0.6, 2e-3}).materials.front().prony;
  CHECK((prony[0].g == 0.4 && prony[0].k == 0.1 && prony[0].time == 2e-3));
  CHECK((prony[1].g == 0.5 && prony[1].k == 0.6 && prony[1].time == 1e-2));
  CHECK_THROWS_WITH(
      at({0.7, 0.3, 0, 1e-3}),
      ContainsSubstring("parameters.toml: the unknowns give material.prony with fractions g that "
                        "add up to 1; expected a sum below 0.9999"));
  CHECK_THROWS_WITH(at({0.3, 0.2, 0.95, 1e-3}), ContainsSubstring("fractions k that add up to 1.05"));
  CHECK_THROWS_WITH(at({-0.1, 0.2, 0, 1e-3}), ContainsSubstring("\"prony.g 0\" is -0.1; expected a number"));
  CHECK_THROWS_WITH(at({0.3, 0.2, 0, 0}),
                    ContainsSubstring("\"prony.time 0\" is 0; expected a number greater"));
}
