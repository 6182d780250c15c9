// SPDX-License-Identifier: GPL-3.0-or-later
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
#include <tuple>
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
    CHECK_THAT(scene::echo(scene, 2), ContainsSubstring(fmt::format(
                                          "obstacle = {{ name = \"obstacle 1\", {} }}{}\n", obstacle, unit)));
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

TEST_CASE("the former names of a choice are read, and pose the same problem", "[scene]") {
  const auto file = test::source("scenes/half-disc.toml");
  for (const auto& [former, name] :
       {std::pair<std::string, std::string>{"P1", "nodal"}, {"P0", "cellwise"}}) {
    INFO(former);
    const std::string echo = scene::echo(test::parse(file, {"control.space=" + former}), 2);
    CHECK(echo == scene::echo(test::parse(file, {"control.space=" + name}), 2));
    const std::string line = "\nspace = \"" + name + "\"";
    REQUIRE_THAT(echo, ContainsSubstring(line));
    std::string old = echo; // as version 0.1 wrote it
    old.replace(old.find(line), line.size(), "\nspace = \"" + former + "\"");
    CHECK(scene::difference(old, echo).first.empty());
    const std::string other = scene::echo(
        test::parse(file, {std::string("control.space=") + (name == "nodal" ? "cellwise" : "nodal")}), 2);
    CHECK(scene::difference(old, other).first == "control.space = \"" + name + '"');
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
  CHECK((all.fields.size() == 4 && all.tables.size() == 7));
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

TEST_CASE("a time series is linear between its times", "[scene]") {
  // The kinds of table that programs write.
  for (const char* text : {"t,u,v\n0,5,1\n0.5,6,2\n2,7,-1\n",
                           "\xef\xbb\xbf# of a sensor\r\nu;time;v\r\n5;0;1\r\n6;5e-1;+2\r\n\r\n7;2;-1",
                           "\"s, exact\"\t u \t\"v\"\n 0\t5\t1\n 0.5\t6\t2\n2\t7\t-1"}) {
    INFO(text);
    const scene::TimeSeries series(text, "v");
    CHECK((series.begin() == 0 && series.end() == 2));
    for (const auto& [t, value] :
         {std::pair{0.0, 1.0}, {0.25, 1.5}, {0.5, 2.0}, {1.0, 1.0}, {2.0, -1.0}, {9.0, -1.0}})
      CHECK(series(t) == value);
    CHECK((series.slope(0.5, false) == 2 && series.slope(0.5, true) == -2));
    CHECK((series.slope(0.5 + 1e-12, false) == 2 && series.slope(0.5 - 1e-12, true) == -2));
    CHECK((series.slope(0, true) == 2 && series.slope(2, false) == -2 && series.slope(0.3, false) == 2));
  }
  for (const auto& [text, column, problem] :
       {std::tuple{"t,force\n0,1\n1,2\n", "forces", "did you mean \"force\"?"},
        {"t,v\n0,1\n0,2\n", "v", "line 3: found the time 0 s behind 0 s"},
        {"t,v\n0,1\n1,two\n", "v", "line 3: found \"two\" in column 2"},
        {"t,v\n0,1\n1\n", "v", "line 3: found \"\" in column 2"},
        {"t;v\n0;1\n1;2,5\n", "v", "found \"2,5\""},
        {"t,v\n0,1\n1,inf\n", "v", "found \"inf\""},
        {"t,v\n0,1\n", "v", "found 1 line of numbers"},
        {"", "v", "found 0 lines"}})
    CHECK_THROWS_WITH(scene::TimeSeries(text, column), ContainsSubstring(problem));
}

TEST_CASE("a time series stands where an expression of time may", "[scene]") {
  const auto file = test::source("tests/data/block.toml");
  const auto made = [&](const std::string& setting, const std::string& content = "t,v\n0,1\n1,3\n") {
    return scene::parse(scene::read(file), file, {setting}, [&](const std::filesystem::path& path) {
      CHECK(path == std::filesystem::weakly_canonical(file.parent_path() / "a.csv"));
      return content;
    });
  };
  const std::string series = "{ file = \"../data/a.csv\", column = \"v\" }", pair = "[0, " + series + "]";
  for (const std::string& setting :
       {"load.body=" + pair, "load.gravity=" + pair, "load.traction=[{on = \"top\", value = " + pair + "}]",
        "clamp=[{on = \"left\", value = " + pair + "}]", "contact.obstacle.point=" + pair,
        "contact.obstacle={shape = \"ball\", center = " + pair + ", radius = " + series + "}",
        "control.initial=" + pair, "objective.desired={control = " + pair + "}",
        "objective.desired={displacement = " + pair + "}", "check.control=" + pair}) {
    INFO(setting);
    const scene::Scene scene = made(setting);
    CHECK_FALSE(scene.digest_of_series.empty());
    const std::string echo = scene::echo(scene, 2);
    CHECK(echo.find("column = \"v\"") != std::string::npos);
    const auto again = scene::parse(echo, file, {}, [](const auto&) { return "t,v\n0,1\n1,3\n"; });
    CHECK(scene::echo(again, 2) == echo);
    CHECK(scene.digest_of_series != made(setting, "t,v\n0,1\n1,4\n").digest_of_series);
    CHECK_THROWS_WITH(made(setting, "t,v\n0,1\n0.5,3\n"),
                      ContainsSubstring("from 0 to 0.5 s") && ContainsSubstring("0 to 0.6 s"));
  }
  const scene::Field load(*made("load.body=" + pair).load->body, "load.body", true);
  CHECK((load.depends_on_time() && !load.depends_on_place()));
  const double x[] = {7, 7, 7};
  double value[2];
  load.evaluate(x, 0.25, value);
  CHECK((value[0] == 0 && value[1] == 1.5));
  CHECK((!load.slope(0, 0.25, true) && load.slope(1, 0.25, true) == 2));
  CHECK_THROWS_WITH(made("initial.velocity=" + pair), ContainsSubstring("place alone"));
  CHECK_THROWS_WITH(made("load.body=[0, {file = \"a.csv\"}]"),
                    ContainsSubstring("load.body.column: missing"));
  CHECK_THROWS_WITH(made("load.body=[0, {file = \"a.csv\", colum = \"v\"}]"),
                    ContainsSubstring("did you mean \"column\"?"));
}

TEST_CASE("an expression that is wrong is told what expressions are", "[scene]") {
  for (const char* part : {"sqrt", "atan2", "a ? b : c", "^", "pi and e", "x, y, z, t"})
    CHECK_THROWS_WITH(scene::Field({"sine(t)"}, "load.body", true), ContainsSubstring(part));
}

TEST_CASE("what --set gave is blamed on it, and what the file gave on the file", "[scene]") {
  for (const auto& [key, plain] : {std::pair{"material.0.young", "material.young"},
                                   {"material[1].viscosity.bulk", "material.viscosity.bulk"},
                                   {"mesh.size", "mesh.size"},
                                   {"contact", "contact"}})
    CHECK(scene::without_numbers(key) == plain);
  const auto file = test::source("tests/data/two-materials.toml");
  for (const auto& [setting, said] :
       {std::pair{"material.1.young=-1", "--set material[1].young: found -1"},
        {"contact.obstacle={shape = \"ball\", radius = 1}", "--set contact.obstacle.center: missing"},
        {"contact.obstacle.shape=\"ball\"", "two-materials.toml:26: contact.obstacle.center: missing"},
        {"run.tolerance=2", "--set run.tolerance: found 2"}})
    CHECK_THROWS_WITH(test::parse(file, {setting}), ContainsSubstring(said));
  CHECK_THROWS_WITH(scene::require_dimension(test::parse(file, {"load={body = [0, 0, 0]}"}), 2),
                    ContainsSubstring("--set load.body: found 3"));
  CHECK_THROWS_WITH(scene::require_dimension(test::parse(file, {"mesh.size=1"}), 3),
                    ContainsSubstring("two-materials.toml: contact.obstacle.point: found 2"));
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
