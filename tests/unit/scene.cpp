#include "base/error.h"
#include "fixtures.h"
#include "io/manifest.h"
#include "scene/compatibility.h"
#include "scene/expression.h"
#include "scene/names.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <fmt/format.h>
#include <fstream>
#include <set>
#include <unistd.h>

using namespace signorini;
using Catch::Matchers::ContainsSubstring;

namespace {

/// A scene file of this rank's own.
std::filesystem::path temporary(const std::string& text) {
  const auto file =
      std::filesystem::temp_directory_path() / ("signorini-unit-" + std::to_string(getpid()) + ".toml");
  std::ofstream(file) << text;
  return file;
}

} // namespace

TEST_CASE("the echoed scene reads back to itself", "[scene]") {
  for (const auto& [name, dim] : {std::pair{"scenes/half-disc.toml", 2},
                                  {"tests/data/block.toml", 2},
                                  {"tests/data/manufactured.toml", 2},
                                  {"scenes/half-ball.toml", 3},
                                  {"tests/data/manufactured-space.toml", 3},
                                  {"tests/data/two-materials.toml", 2}}) {
    const scene::Scene scene = test::parse(test::source(name), {"solver.vi=full"});
    CHECK(scene.solver.vi == scene::ViMethod::full);
    CHECK_NOTHROW(scene::require_dimension(scene, dim));
    CHECK_THROWS_AS(scene::require_dimension(scene, 5 - dim), UserError);
    const std::string text = scene::echo(scene, dim);
    const auto file = temporary(text);
    CHECK_NOTHROW(
        scene::require_dimension(test::parse(file), dim)); // defaults have as many components as the body
    CHECK(scene::echo(test::parse(file), dim) == text);
    std::filesystem::remove(file);
  }
}

TEST_CASE("the echo leaves the start to clamps that move", "[scene]") {
  const auto file = test::source("tests/data/block.toml"); // gives a velocity and no displacement
  for (const auto& [value, moves] : {std::pair{"[\"0\", \"0\"]", false}, {"[\"0\", \"t\"]", true}}) {
    const scene::Scene scene =
        test::parse(file, {fmt::format("clamp=[{{ on = \"left\", value = {} }}]", value)});
    const auto echo = temporary(scene::echo(scene, 2));
    const scene::Initial initial = test::parse(echo).initial;
    CHECK(initial.displacement.has_value() == !moves);
    CHECK(initial.velocity == scene.initial.velocity);
    std::filesystem::remove(echo);
  }
}

TEST_CASE("an obstacle is echoed with the unit of its lengths, and a level set, which has any, with none",
          "[scene]") {
  for (const auto& [obstacle, unit] :
       {std::pair{"shape = \"half-space\", point = [0.0, \"-t\"], normal = [0.0, 2.0]", "  # m"},
        {"shape = \"ball\", center = [0.0, -2.0], radius = 1.5, side = \"outside\"", "  # m"},
        {"shape = \"cylinder\", point = [0.0, -2.0], radius = 9.0, side = \"inside\"", "  # m"},
        {"shape = \"signed-distance\", distance = \"y + 1 - 0.1*x^2\"", ""}}) {
    const scene::Scene scene = test::parse(test::source("tests/data/block.toml"),
                                           {fmt::format("contact.obstacle={{ {} }}", obstacle)});
    CHECK_THAT(scene::echo(scene, 2),
               ContainsSubstring(fmt::format("obstacle = {{ {} }}{}\n", obstacle, unit)));
  }
}

TEST_CASE("the table of keys says what poses the problem", "[scene]") {
  const auto file = test::source("scenes/half-disc.toml");
  const auto echo = [&](const std::vector<std::string>& overrides) {
    return scene::echo(test::parse(file, overrides), 2);
  };
  const std::string first = echo({});
  for (const char* other : {"optimizer.tolerance=1e-3", "optimizer.method=newton-cg", "output.every=7",
                            "run.invariants=off", "trajectory.storage=disk", "solver.memory=1e9",
                            "exact.impulse=1.0", "check.control=[\"0\", \"1\"]"}) {
    INFO(other);
    CHECK(scene::difference(first, echo({other})).first.empty());
  }
  for (const char* other :
       {"objective.alpha=0.5", "mesh.size=2", "time.step=2.5e-5", "control.upper=1.0", "solver.vi=full"}) {
    INFO(other);
    CHECK_FALSE(scene::difference(first, echo({other})).second.empty());
  }
  const std::string method = echo({"optimizer.method=newton-cg"});
  CHECK(scene::difference(first, method, scene::Part::search).second == "optimizer.method = \"newton-cg\"");
  for (const char* other : {"trajectory.storage=disk", "solver.memory=1e9", "check.control=[\"0\", \"1\"]"}) {
    INFO(other);
    CHECK(scene::difference(first, echo({other}), scene::Part::search).first.empty());
    CHECK_FALSE(scene::difference(first, echo({other}), scene::Part::measurement).second.empty());
  }
}

TEST_CASE("every effect is that of a key", "[scene]") {
  std::set<std::string> said{""}, known{""};
  for (const scene::KeyLine& key : scene::keys())
    said.insert(key.effect);
  for (const auto& [name, on] : io::effects(test::parse(test::source("scenes/half-disc.toml"))))
    known.insert(name);
  CHECK(said == known);
}

TEST_CASE("a list of names is a set, and may be empty", "[scene]") {
  const auto file = test::source("scenes/half-disc.toml");
  const scene::Output all = test::parse(file).output;
  CHECK((all.fields.size() == 4 && all.tables.size() == 3));
  const scene::Output some =
      test::parse(file, {"output.fields=[\"adjoint\", \"velocity\", \"adjoint\"]", "output.tables=[]"})
          .output;
  CHECK(some.fields == std::vector{scene::StoredField::adjoint, scene::StoredField::velocity});
  CHECK(some.tables.empty());
  CHECK((some.field(scene::StoredField::adjoint) && !some.field(scene::StoredField::control) &&
         !some.table(scene::StoredTable::steps)));
  const scene::Scene scene = test::parse(file, {"output.fields=[]", "output.tables=[\"contact\"]"});
  const auto echo = temporary(scene::echo(scene, 2));
  const scene::Output echoed = test::parse(echo).output;
  CHECK((echoed.fields.empty() && echoed.tables == std::vector{scene::StoredTable::contact}));
  std::filesystem::remove(echo);
}

TEST_CASE("an earlier run's folder is relative to the scene file, and echoed as it is found", "[scene]") {
  const std::string text =
      "[mesh]\nfile = \"a.msh\"\n[time]\nend = 1.0\nstep = 0.5\n[material]\ndensity = 1.0\nyoung = "
      "1.0\npoisson = 0.3\n"
      "[control]\nscale = 1.0\n[objective]\ndesired = { run = \"../runs/first\" }\nalpha = 1.0\n";
  const scene::Scene scene = scene::parse(text, "/somewhere/scenes/a.toml");
  const auto folder = [](const scene::Scene& s) {
    return std::get<scene::DesiredRun>(s.objective->desired).folder;
  };
  CHECK(folder(scene) == "/somewhere/runs/first");
  CHECK(folder(scene::parse(scene::echo(scene, 2), "/elsewhere/b.toml")) == "/somewhere/runs/first");
  CHECK_NOTHROW(scene::require_dimension(scene, 2));
}

TEST_CASE("an override reaches what it names and nothing else", "[scene]") {
  const auto file = test::source("scenes/half-disc.toml");
  const scene::Scene scene = test::parse(
      file, {"mesh.size=0.25", "control.upper=[1, 2]", "clamp.0.on=side", "load.body=[\"0\", \"-9.81*t\"]"});
  CHECK(scene.mesh.size == 0.25);
  CHECK(scene.control->upper == std::vector<double>{1, 2});
  CHECK(scene.clamps.front().on == "side");
  CHECK(scene.load->body->back() == "-9.81*t");
  CHECK(scene.time.steps == test::parse(file).time.steps);
  CHECK_FALSE(test::parse(file).load);
}

TEST_CASE("an override reaches one of several materials", "[scene]") {
  const auto file = test::source("tests/data/two-materials.toml");
  const scene::Scene before = test::parse(file),
                     scene = test::parse(file, {"material.0.young=7", "material.1.viscosity.bulk=9"});
  CHECK(before.materials.size() == 2);
  CHECK(scene.materials.front().on == "left");
  CHECK(scene.materials.front().young == 7);
  CHECK_FALSE(scene.materials.front().viscosity);
  CHECK(scene.materials.back().young == before.materials.back().young);
  CHECK(scene.materials.back().viscosity->bulk == 9);
  CHECK(scene.materials.back().viscosity->shear == before.materials.back().viscosity->shear);
  CHECK_FALSE(test::parse(test::source("tests/data/block.toml")).materials.front().on);
}

TEST_CASE("the number of steps is exact for decimal steps", "[scene]") {
  const auto file = test::source("scenes/half-disc.toml");
  for (const auto& [step, steps] : {std::pair{"1e-6", 7500}, {"2.5e-5", 300}, {"7.5e-3", 1}})
    CHECK(test::parse(file, {std::string("time.step=") + step}).time.steps == steps);
  CHECK_THROWS_WITH(test::parse(file, {"time.step=4e-5"}),
                    ContainsSubstring("time.end") && ContainsSubstring("187.5"));
}

TEST_CASE("a misspelt name gets the nearest valid one", "[scene]") {
  CHECK(scene::nearest("poison", {"poisson", "young"}) == "poisson");
  CHECK(scene::nearest("tpo", {"top", "contact"}) == "top");
  CHECK(scene::nearest("zzzzzz", {"top", "contact"}).empty());
}

TEST_CASE("fields evaluate, know of time, and must be finite", "[scene]") {
  const double x[] = {0.5, -2, 0};
  double value[2];
  const scene::Field field({"x*y + sin(pi*t)", "e"}, "load.body", true);
  CHECK(field.depends_on_time());
  field.evaluate(x, 0.5, value);
  CHECK(std::abs(value[0] - 0.0) < 1e-15);
  CHECK(std::abs(value[1] - std::exp(1.0)) < 1e-15);
  CHECK_FALSE(scene::Field({"x", "y"}, "load.body", true).depends_on_time());
  CHECK_THROWS_AS(scene::Field({"x", "t"}, "initial.velocity", false), UserError);
  CHECK_THROWS_WITH(scene::Field({"1/(y+2)", "0"}, "load.body", true).evaluate(x, 0, value),
                    ContainsSubstring("load.body") && ContainsSubstring("y = -2"));
}
