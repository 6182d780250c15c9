// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/body_figures.h"
#include "base/collective.h"
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <fmt/format.h>

using namespace signorini;
using Catch::Matchers::ContainsSubstring;

namespace {

diagnostics::BodyFigures figures(const std::string& file, const std::vector<std::string>& overrides = {}) {
  const test::Ready ready(file, overrides);
  return diagnostics::body_figures(ready.problem.stepper, ready.scene);
}

void require_near(double found, double expected) { CHECK(std::abs(found / expected - 1) < 1e-12); }

} // namespace

TEST_CASE("a body is told by its extent, mass and waves", "[forward]") {
  for (const char* degree : {"mesh.degree=1", "mesh.degree=2"}) {
    CAPTURE(degree);
    const diagnostics::BodyFigures block = figures("tests/data/block.toml", {degree});
    CHECK((block.dim == 2 && block.warnings.empty()));
    require_near(block.extent[0], 1);
    require_near(block.extent[1], 1);
    require_near(block.mass, 1);
    require_near(block.pressure_waves[1], std::sqrt(50 * 0.7 / (1.3 * 0.4)));
    require_near(block.shear_waves[0], std::sqrt(50 / 2.6));
    require_near(block.crossing_steps, 1 / std::sqrt(50 * 0.7 / (1.3 * 0.4)) / 0.02);
    CHECK_THAT(block.line(), ContainsSubstring("body: 1 x 1 m, 1 kg/m; pressure waves 8.2 m/s"));
    const diagnostics::BodyFigures cube = figures("tests/data/cube.toml", {degree, "material.density=8"});
    require_near(cube.mass, 8);
    CHECK_THAT(cube.line(), ContainsSubstring("1 x 1 x 1 m, 8 kg;"));
  }
  const diagnostics::BodyFigures parts = figures("tests/data/two-materials.toml");
  require_near(parts.mass, 4);
  require_near(parts.pressure_waves[0], std::sqrt(200 / 3.0 * 0.8 / (1.2 * 0.6)));
  require_near(parts.pressure_waves[1], std::sqrt(50 * 0.65 / (1.35 * 0.3)));
  require_near(parts.crossing, 2 / parts.pressure_waves[1]);
  CHECK_THAT(parts.line(), ContainsSubstring("8.61 to 8.96 m/s"));
}

TEST_CASE("notes tell of sizes without effect and of points outside", "[mesh]") {
  for (const char* size : {"mesh.scale=0.5", "mesh.size=0.01"}) {
    const auto notes = figures("scenes/two-bars.toml", {size}).notes;
    if (rank(MPI_COMM_WORLD) == 0) { // which reads the file
      REQUIRE(notes.size() == 1);
      CHECK_THAT(notes.front(), ContainsSubstring("has no effect on two-bars.geo"));
    }
  }
  CHECK(figures("scenes/two-bars.toml").notes.empty());
  for (const char* size : {"mesh.size=0.1", "mesh.size=4"}) // elements as long as the sides, too
    CHECK(figures("tests/data/block.toml", {size}).notes.empty());
  const auto outside = [](const char* point) {
    return figures("tests/data/block.toml", {"mesh.size=0.05", point}).notes;
  };
  CHECK(outside("output.probe=[{point=[1, 0.5]}]").empty());
  REQUIRE(outside("output.probe=[{point=[1.01, 0.5]}]").size() == 1);
  CHECK_THAT(outside("output.probe=[{point=[1.01, 0.5]}]").front(),
             ContainsSubstring("0.01 m outside of the body"));
}

TEST_CASE("a mesh in another unit is brought to metres", "[mesh]") {
  for (const auto& [unit, length] :
       {std::pair{"m", 1.0}, {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}, {"in", 0.0254}}) {
    const std::string size = fmt::format("mesh.size={}", 0.25 * length);
    const diagnostics::BodyFigures drawn =
        figures("tests/data/block.toml",
                {fmt::format("mesh.unit={}", unit), size, "contact.obstacle.point=[0, -100]"});
    require_near(drawn.extent[0], length);
    require_near(drawn.mass, length * length);
    const test::Ready ready("tests/data/block.toml",
                            {fmt::format("mesh.unit={}", unit), size, "contact.obstacle.point=[0, -100]"});
    CHECK(ready.problem.mesh.cells() == test::Ready("tests/data/block.toml").problem.mesh.cells());
  }
}

TEST_CASE("units that were mistaken are doubted, and the scenes here are not", "[forward]") {
  using Settings = std::vector<std::string>;
  const std::string steel = "material={density = 7850, young = 2.1e11, poisson = 0.3}",
                    slow = "time={end = 1, step = 0.1}";
  for (const auto& [settings, said] : std::vector<std::pair<Settings, const char*>>{
           {{"material.density=1e-9", "material.young=210000"}, "faster than in any solid"}, // t/mm³ and MPa
           {{"material.density=7.85", "material.young=2.1e11"}, "faster than in any solid"}, // g/cm³
           {{"material.density=7850", "material.young=210000"},
            "slower than in any solid of 7850 kg/m³"},                    // MPa
           {{"material.density=7850000"}, "more than that of any solid"}, // g/m³
           {{steel, "time={end = 1e-4, step = 1e-5}"}, "before a wave has crossed the body of 1 m"},
           {{steel, slow}, "such steps resolve no waves, only slower motions"},
           {{"contact.obstacle={shape=\"half-space\", point=[0, 0], normal=[0, -1]}"},
            "% of the body is inside the obstacle"},
           {{"clamp=[{on=\"top\"}]", "initial.velocity=[\"0\", \"0\"]", "mesh.file=../../meshes/bar.geo",
             "mesh.size=0.5", "time.end=2", "contact.on=contact", "contact.obstacle.normal=[0, 1]"},
            "too stiff in bending"},
           {{"contact.obstacle.point=[0, -100]"}, "the obstacle is 95.8 m away"},
           {{"mesh.unit=um", "mesh.size=2.5e-7", "contact.obstacle.point=[0, -1e-6]"},
            "the body is 1e-06 m long"}}) {
    const diagnostics::BodyFigures found = figures("tests/data/block.toml", settings);
    INFO(said);
    for (const std::string& warning : found.warnings)
      UNSCOPED_INFO(warning);
    REQUIRE(found.warnings.size() == 1);
    CHECK_THAT(found.warnings.front(), ContainsSubstring(said));
  }
  for (const auto& [file, overrides] : std::vector<std::pair<const char*, Settings>>{
           {"scenes/half-disc.toml", {"mesh.size=3"}},
           {"scenes/half-ball.toml", {"mesh.size=4"}},
           {"scenes/bar-impact.toml", {"mesh.size=1"}},
           {"scenes/bouncing-bar.toml", {"mesh.size=1"}},
           {"scenes/catch.toml", {"mesh.size=0.2"}},
           {"scenes/disc-drop.toml", {"mesh.size=5"}},
           {"scenes/hertz-press.toml", {"mesh.scale=8"}},
           {"scenes/standing-wave.toml", {"mesh.size=1"}},
           {"tests/data/block.toml", // a bar that cannot bend
            {"clamp=[{on=\"free\", components=[\"x\"]}]", "mesh.file=../../meshes/bar.geo", "mesh.size=0.5",
             "time.end=2", "contact.on=contact", "contact.obstacle.normal=[0, 1]"}},
           {"tests/data/block.toml", {}}}) {
    INFO(file);
    CHECK(figures(file, overrides).warnings.empty());
  }
}
