// SPDX-License-Identifier: GPL-3.0-or-later
#include "control/interpolation.h"
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>

using namespace signorini;

namespace {

/// A scene's control space alone.
struct Space {
  scene::Scene scene;
  std::shared_ptr<const problem::SpaceDiscretisation> shared;
  fem::Space space;
  fem::Operators operators;
  control::ControlSpace controls;

  explicit Space(const std::vector<std::string>& settings, const char* file = "tests/data/block.toml")
      : scene(test::parse(test::source(file), settings)), shared(test::discretised(scene)),
        space(shared->mesh, scene.mesh.degree),
        operators(fem::assemble_operators(space, scene.materials, true)),
        controls(space, operators, step::TimeGrid(scene.time), *scene.control) {}
};

double difference(const control::Control& a, const control::Control& b) {
  return test::difference(a.values(), b.values());
}

constexpr double rounding = 1e-13; // of values up to 3, sums of a few products

} // namespace

TEST_CASE("a linear control is the same on any mesh", "[control]") {
  const std::string here = "mesh.size=0.11", there = "mesh.size=0.3", twice = "mesh.degree=2";
  using Settings = std::vector<std::string>;
  const Settings y_alone{"control.components=[\"y\"]", "objective.desired={control=[\"0\", \"-1\"]}"};
  for (const auto& [from, to] : std::vector<std::pair<Settings, Settings>>{
           {{there}, {here}},
           {{there, twice}, {here}},
           {{there}, {here, twice}},
           {{here}, {there, twice}}, // from fine to coarse too
           {{there, "control.on=top"}, {here, "control.on=top"}},
           {{there, "control.on=rest", twice}, {here, "control.on=rest"}},
           {{there, y_alone[0], y_alone[1]}, {here, y_alone[0], y_alone[1]}},
           {{there}, {here, "control.space=cellwise"}}}) {
    CAPTURE(from, to);
    const Space coarse(from), fine(to);
    const bool all = coarse.controls.components().size() == 2;
    const scene::Components linear{all ? "1 + x - 2*y" : "0", "t + y"};
    const control::Interpolation interpolate(coarse.controls, fine.controls);
    const control::Control expected = fine.controls.interpolate(linear, "test");
    REQUIRE(test::largest(expected.values()) > 0.5);
    CHECK(difference(interpolate(coarse.controls.interpolate(linear, "test")), expected) < rounding);
  }
}

TEST_CASE("a quadratic control of degree 2 is the same on any mesh", "[control]") {
  const Space coarse({"mesh.size=0.3", "mesh.degree=2"}), fine({"mesh.size=0.11", "mesh.degree=2"});
  const scene::Components quadratic{"x^2 - x*y", "y^2 + t"};
  const control::Interpolation interpolate(coarse.controls, fine.controls);
  CHECK(difference(interpolate(coarse.controls.interpolate(quadratic, "test")),
                   fine.controls.interpolate(quadratic, "test")) < rounding);
}

TEST_CASE("a control in space is interpolated", "[control]") {
  const char* on = GENERATE(as<const char*>{}, "", "control.on=top");
  CAPTURE(on);
  std::vector<std::string> from{"mesh.size=0.6", "control={scale=1}",
                                "objective={desired={displacement=[\"0\", \"0\", \"0\"]}}"},
      to = from;
  to[0] = "mesh.size=0.34";
  for (auto* settings : {&from, &to})
    if (*on)
      settings->emplace_back(on);
  const Space coarse(from, "tests/data/cube.toml"), fine(to, "tests/data/cube.toml");
  const scene::Components linear{"x + y", "z - t", "1 - 2*z"};
  const control::Interpolation interpolate(coarse.controls, fine.controls);
  CHECK(difference(interpolate(coarse.controls.interpolate(linear, "test")),
                   fine.controls.interpolate(linear, "test")) < rounding);
}

TEST_CASE("a control with values in cells keeps them where it is evaluated", "[control]") {
  const char* on = GENERATE(as<const char*>{}, "control.on=body", "control.on=top");
  CAPTURE(on);
  const Space coarse({"mesh.size=0.3", "control.space=cellwise", on}),
      fine({"mesh.size=0.11", "control.space=cellwise", on});
  const control::Interpolation interpolate(coarse.controls, fine.controls);
  CHECK(difference(interpolate(coarse.controls.constant(0.7)), fine.controls.constant(0.7)) < rounding);
  const control::Control u = interpolate(coarse.controls.interpolate({"x", "y"}, "test")),
                         linear = fine.controls.interpolate({"x", "y"}, "test");
  const double away = difference(u, linear); // of a midpoint, or of two where facets are looked for
  CHECK(away > 0.01);
  CHECK(away < 0.3);
}

TEST_CASE("each step has the mean of a control over its duration", "[control]") {
  // 30 steps of 0.02 s; 10, 7 and 1 of the same time.
  const Space fine({"mesh.size=0.5"});
  const double T = fine.scene.time.end;
  for (const char* step :
       {"time.step=0.06", "time.step=0.0857142857142857", "control.constant_in_time=true"}) {
    const Space coarse({"mesh.size=0.5", step});
    const control::Interpolation refine(coarse.controls, fine.controls),
        coarsen(fine.controls, coarse.controls);
    const scene::Components varying{*step == 'c' ? "2" : "t", "1"};
    const control::Control u = coarse.controls.interpolate(varying, "test"), on_fine = refine(u);
    const control::Control one = fine.controls.constant(1);
    // Its integral is kept, and its square's too where steps are whole parts.
    CHECK(std::abs(fine.controls.product(on_fine, one) -
                   coarse.controls.product(u, coarse.controls.constant(1))) < rounding * T);
    if (coarse.controls.count() != 7) {
      const scene::Components mean{coarse.controls.count() == 1 ? std::to_string(T / 2) : "t", "0"};
      CHECK(difference(coarsen(fine.controls.interpolate({"t", "0"}, "test")),
                       coarse.controls.interpolate(mean, "test")) < rounding);
      CHECK(std::abs(fine.controls.norm(on_fine) - coarse.controls.norm(u)) < rounding);
      CHECK(difference(coarsen(on_fine), u) < rounding);
    }
  }
}

TEST_CASE("points beside a curved boundary are met", "[control]") {
  // Nodes of the finer disc are outside of the coarse polygon, by h^2/8R = 0.13 m at most.
  const bool on_surface = GENERATE(false, true);
  CAPTURE(on_surface);
  std::vector<std::string> from{"mesh.size=4"}, to{"mesh.size=1.3"};
  if (on_surface)
    for (auto* settings : {&from, &to})
      settings->emplace_back("control.on=contact");
  const Space coarse(from, "scenes/half-disc.toml"), fine(to, "scenes/half-disc.toml");
  const control::Interpolation interpolate(coarse.controls, fine.controls);
  const double away = difference(interpolate(coarse.controls.interpolate({"x", "y"}, "test")),
                                 fine.controls.interpolate({"x", "y"}, "test"));
  CHECK(away < (on_surface ? 0.14 : 1e-11)); // the nearest point's value; the polynomial's, exact
  CHECK(difference(interpolate(coarse.controls.constant(1)), fine.controls.constant(1)) < rounding);
}

TEST_CASE("pairs of steps and gradient differences keep their products", "[control]") {
  const Space coarse({"mesh.size=0.2", "time.step=0.04"}), fine({"mesh.size=0.1"});
  const control::Interpolation interpolate(coarse.controls, fine.controls);
  const control::Control s = coarse.controls.interpolate({"sin(4*x + t)", "y*t"}, "test"),
                         y = coarse.controls.interpolate({"sin(4*x + t) + 0.1*y", "2*y*t"}, "test");
  const double before = coarse.controls.inner(s, y);
  REQUIRE(before > 0);
  CHECK(std::abs(fine.controls.inner(interpolate(s), interpolate(y)) / before - 1) < 0.02);
}
