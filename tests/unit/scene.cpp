// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/error.h"
#include "base/text.h"
#include "fixtures.h"
#include "io/manifest.h"
#include "scene/compatibility.h"
#include "scene/expression.h"
#include "scene/table.h"
#include "scene/units.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <set>
#include <string_view>
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
    CAPTURE(name, dim);
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
    CAPTURE(value, moves);
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

TEST_CASE("an override without a value, as --unset gives it, removes a key or a table", "[scene]") {
  const auto file = test::source("scenes/half-disc.toml");
  const auto echo = [&](const std::vector<std::string>& overrides) {
    return scene::echo(test::parse(file, overrides), 2);
  };
  CHECK(echo({"check.control=[\"0\", \"1\"]", "check="}) == echo({}));
  CHECK(echo({"contact.friction=0.3", "contact.friction="}) == echo({}));
  CHECK(echo({"contact.friction=0.3"}) != echo({}));
  const std::string two = R"(output.probe=[{point=[0,-15], name="a"}, {point=[0,0], name="b"}])",
                    second = R"(output.probe=[{point=[0,0], name="b"}])";
  CHECK(echo({two, "output.probe.0="}) == echo({second}));
  CHECK(echo({two, "output.probe.1=", "output.probe.0="}) == echo({}));
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
  const scene::Difference laws =
      scene::difference(echo({"contact.friction=0.3"}), echo({"contact.friction={bound=\"2e5\"}"}));
  CHECK(laws.first == "contact.friction = 0.3");
  CHECK(laws.second == "contact.friction.bound = 200000");
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
  CHECK((all.fields.size() == 4 && all.tables.size() == 9));
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
        {"t,v\n0,1\n0,2\n", "v", "line 3: found the time 0 s after 0 s"},
        {"t,v\n0,1\n1,two\n", "v", "line 3: found \"two\" in column 2"},
        {"t,v\n0,1\n1\n", "v", "line 3: found \"\" in column 2"},
        {"t;v\n0;1\n1;2,5\n", "v", "found \"2,5\""},
        {"t,v\n0,1\n1,inf\n", "v", "found \"inf\""},
        {"t,v\n0,1\n", "v", "found 1 line of numbers"},
        {"", "v", "found 0 lines"},
        {"t,v\n0,0\n0,0,-1,5\n", "v", "line 3: found 4 cells below 2 column names"}, // decimal commas
        {"t,v,w\n0,0,1\n1,-1,000,1\n", "v", "line 3: found 4 cells below 3 column names"},
        {"t,v\n0,0\n1,\"-1,000\"\n", "v", "line 3: found \"-1,000\" in column 2"},
        {"t,v\n0,0\n1,\"-1\n", "v", "line 3: found \"\"-1\" in column 2"},
        {"t,v,v\n0,0,1\n1,1,2\n", "v", "found \"v\" in column 2 and \"v\" in column 3"},
        {"t,v,t\n0,0,1\n1,1,2\n", "v", "found \"t\" in column 1 and \"t\" in column 3"},
        {"t,v [mm],v [m]\n0,0,1\n1,1,2\n", "v", "found \"v [mm]\" in column 2 and \"v [m]\" in column 3"},
        {"v,w\n0,0\n1,1\n", "v", "no column of times"},
        {"# t,v\n0,1\n1,2\n", "v", "line 2: found numbers; column names must be in the first line"},
        {"Device: 5\nt,v\n0,1\n1,2\n", "v", "line 1: found \"Device: 5\"; column names must be"},
        {"t v\n0 1\n1 2\n", "v", "separated by commas, semicolons or tabs"},
        {"t,v [mV]\n0,0\n1,1\n", "v", "unknown unit in \"v [mV]\""},
        {"t,v [s]\n0,0\n1,1\n", "v", "\"v [s]\", which cannot be converted to m"},
        {"time [mm],v\n0,0\n1,1\n", "v", "times in the unit of \"time [mm]\""},
        {"stamp [ticks],v\n0,0\n1,1\n", "v", "times in the unit of \"stamp [ticks]\""}})
    CHECK_THROWS_WITH(scene::read_column(text, column, {"m"}), ContainsSubstring(problem));
  std::string utf16;
  for (const char c : std::string_view("t,v\n0,1\n1,2\n"))
    utf16 += {c, '\0'};
  CHECK_THROWS_WITH(scene::read_column(utf16, "v"), ContainsSubstring("save the table as UTF-8"));
}

TEST_CASE("columns are converted by the units of their names", "[scene]") {
  for (const char* text :
       {"time [ms],x [mm]\n0,5\n250,7\n", "time [ms],x [mm]\r0,5\r250,7\r",
        "sep=;\ntime [ms];x [mm]\n0;5\n250;7\n", "x (mm);t (ms)\n5;0\n7;250\n",
        "\"Zeit [ms]\",\"x [mm]\"\n0,\"5\"\n250,\"7\"\n", "Time [min],x [um]\n0,5e3\n0.25e0,7e3\n",
        "x [mm],TIME (ms)\n5,0,\n7,250,\n"}) { // a separator at the end is no cell
    INFO(text);
    const scene::TableColumn column = scene::read_column(text, "x", {"m"});
    CHECK((column.times.front() == 0 && scene::unit_hint(column).empty()));
    CHECK(std::abs(column.times.back() - (std::string_view(text).starts_with("Time [min") ? 15 : 0.25)) <
          1e-15);
    CHECK(std::abs(column.values.front() - 5e-3) < 1e-17);
    CHECK(std::abs(column.values.back() - 7e-3) < 1e-17);
    CHECK(scene::TimeSeries(text, "x").values() == column.values);
    CHECK((scene::has_column(text, "x") && !scene::has_column(text, "y")));
  }
  // A name that matches whole is that name, whose values are as they are; it is said.
  const scene::TableColumn whole = scene::read_column("t,x [mm]\n0,5\n1,7\n", "x [mm]", {"m"});
  CHECK(whole.values == std::vector<double>{5, 7});
  CHECK_THAT(scene::input_warnings(whole, 1).at(0).message,
             ContainsSubstring("to convert them, set column = \"x\""));
  CHECK(scene::data_warnings(whole, 1).size() == 1);
  CHECK(scene::input_warnings(scene::read_column("t,x [1]\n0,5\n1,7\n", "x [1]"), 1).empty());
  // Of both names the one that matches whole counts, and a bracket within a name is part of it.
  CHECK(scene::TimeSeries("t,x [mm],x\n0,5,8\n1,7,9\n", "x").values() == std::vector<double>{8, 9});
  CHECK(scene::TimeSeries("t,x (filtered)\n0,5\n1,7\n", "x (filtered)").values() ==
        std::vector<double>{5, 7});
  for (const auto& [text, factor, dimension] : {std::tuple{"kN/mm^2", 1e9, std::array{-1, 1, -2}},
                                                {"N/mm\u00b2", 1e6, std::array{-1, 1, -2}},
                                                {"MPa", 1e6, std::array{-1, 1, -2}},
                                                {"m/s\u00b2", 1.0, std::array{1, 0, -2}},
                                                {"km/h", 1 / 3.6, std::array{1, 0, -1}},
                                                {"N s", 1.0, std::array{1, 1, -1}},
                                                {"mN\u00b7s", 1e-3, std::array{1, 1, -1}},
                                                {"g/cm^3", 1e3, std::array{-3, 1, 0}},
                                                {"1/ms", 1e3, std::array{0, 0, -1}},
                                                {"m s^-1", 1.0, std::array{1, 0, -1}},
                                                {"\u00b5s", 1e-6, std::array{0, 0, 1}},
                                                {"\xb5s", 1e-6, std::array{0, 0, 1}}, // Latin-1
                                                {"N/mm\xb2", 1e6, std::array{-1, 1, -2}}}) {
    INFO(text);
    const auto found = scene::unit(text);
    REQUIRE(found);
    CHECK(std::abs(found->factor / factor - 1) < 1e-14);
    CHECK(found->dimension == dimension);
  }
  for (const char* none : {"", "mV", "kmin", "m//s", "m/", "/s", "m^", "m^x", "x", "5", "s2s"}) {
    CAPTURE(none);
    CHECK_FALSE(scene::unit(none));
  }
}

TEST_CASE("a table that a run hardly uses is doubted", "[scene]") {
  using Text = std::string;
  const auto table = [](const Text& names, double last, int rows) {
    Text text = names + "\n";
    for (int i = 0; i < rows; ++i)
      text += fmt::format("{},{}\n", last * i / (rows - 1), i);
    return scene::read_column(text, "v");
  };
  const auto one = [](const std::vector<scene::TableWarning>& warnings, const char* text, double value) {
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings.front().message, ContainsSubstring(text));
    CHECK(std::abs(warnings.front().value / value - 1) < 1e-12);
    CHECK(warnings.front().value > warnings.front().limit);
  };
  one(scene::input_warnings(table("t,v", 10, 11), 0.5), "uses one of 10 intervals", 10);
  one(scene::input_warnings(table("t,v", 10, 11), 1), "those of a column \"t [ms]\" are converted", 10);
  CHECK(scene::input_warnings(table("t,v", 10, 11), 1.5).empty());
  one(scene::input_warnings(table("t,v", 1000, 100'001), 0.5), "at most a thousandth of the table", 2000);
  one(scene::input_warnings(table("t,v", 1000, 2), 1), "at most a thousandth of the table", 1000); // in ms
  CHECK(scene::input_warnings(table("t [s],v", 1000, 100'001), 0.5).empty());
  CHECK(scene::input_warnings(table("t,v", 1, 2), 0.5).empty()); // all that it has
  one(scene::data_warnings(table("t,v", 1, 11), 1.2), "the data end at 1 s, but the run at 1.2 s", 2);
  CHECK(scene::data_warnings(table("t,v", 1, 11), 1.1).empty()); // sampled as densely
  one(scene::data_warnings(table("t,v", 1e-3, 11), 2), "a thousandth of the run's 2 s or less", 2000);
  one(scene::data_warnings(table("t [s],v", 1e-3, 11), 2), "is not compared with data", 19990);
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
    const std::vector<scene::NamedSeries> found = scene::time_series(scene);
    CHECK(found.size() == (setting.find("radius") == std::string::npos ? 1 : 2));
    CHECK((found.at(0).file == std::filesystem::weakly_canonical(file.parent_path() / "a.csv") &&
           found.at(0).column == "v"));
    CHECK(setting.starts_with(found.at(0).key.substr(0, found.at(0).key.find_first_of(".["))));
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
  CHECK_THROWS_WITH(made("initial.velocity=" + pair), ContainsSubstring("expressions of position only"));
  CHECK_THROWS_WITH(made("load.gravity=" + pair, "t,v [kN]\n0,1\n1,3\n"),
                    ContainsSubstring("load.gravity: ") && ContainsSubstring("cannot be converted to m/s²"));
  CHECK(made("load.body=" + pair, "t [ms],v [kN/m^3]\n0,1\n1e3,3\n").load->body->back().series->values() ==
        std::vector<double>{1e3, 3e3});
  CHECK_THROWS_WITH(made("load.body=[0, {file = \"a.csv\"}]"),
                    ContainsSubstring("load.body.column: missing"));
  CHECK_THROWS_WITH(made("load.body=[0, {file = \"a.csv\", colum = \"v\"}]"),
                    ContainsSubstring("did you mean \"column\"?"));
}

TEST_CASE("an expression that is wrong is told what expressions are", "[scene]") {
  for (const char* part : {"sqrt", "atan2", "a ? b : c", "^", "pi and e", "x, y, z, t"}) {
    CAPTURE(part);
    CHECK_THROWS_WITH(scene::Field({"sine(t)"}, "load.body", true), ContainsSubstring(part));
  }
}

TEST_CASE("what --set gave is blamed on it, and what the file gave on the file", "[scene]") {
  for (const auto& [key, plain] : {std::pair{"material.0.young", "material.young"},
                                   {"material[1].viscosity.bulk", "material.viscosity.bulk"},
                                   {"mesh.size", "mesh.size"},
                                   {"contact", "contact"}}) {
    CAPTURE(key, plain);
    CHECK(scene::without_numbers(key) == plain);
  }
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
  for (const auto& [step, steps] : {std::pair{"1e-6", 7500}, {"2.5e-5", 300}, {"7.5e-3", 1}}) {
    CAPTURE(step, steps);
    CHECK(test::parse(file, {std::string("time.step=") + step}).time.steps == steps);
  }
  CHECK_THROWS_WITH(test::parse(file, {"time.step=4e-5"}),
                    ContainsSubstring("time.end") && ContainsSubstring("187.5"));
}

TEST_CASE("a misspelt name gets the nearest valid one", "[scene]") {
  CHECK(nearest("poison", {"poisson", "young"}) == "poisson");
  CHECK(nearest("tpo", {"top", "contact"}) == "top");
  CHECK(nearest("zzzzzz", {"top", "contact"}).empty());
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
