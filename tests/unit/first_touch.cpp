// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/body_figures.h"
#include "diagnostics/contact_forces.h"
#include "fixtures.h"
#include "trajectory/approach.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <fmt/format.h>

using namespace signorini;
using Catch::Matchers::ContainsSubstring;
using Settings = std::vector<std::string>;

namespace {

/// The unit's block above a floor 0.1 m below, at rest and without loads.
Settings above_floor(const Settings& more) {
  Settings all{"contact.obstacle={ name=\"floor\", shape=\"half-space\", point=[0, -0.1], normal=[0, 1] }",
               "initial.velocity=[\"0\", \"0\"]", "load.body=[\"0\", \"0\"]"};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

trajectory::FirstTouch touch(const Settings& more) {
  const test::Ready ready("tests/data/block.toml", above_floor(more));
  return trajectory::first_touches(ready.problem.stepper, ready.scene).at(0);
}

std::string line(const Settings& more) {
  const test::Ready ready("tests/data/block.toml", above_floor(more));
  return trajectory::first_touch_lines(ready.problem.stepper, ready.scene).at(0);
}

struct Case {
  Settings settings;
  double time, speed, tolerance = 1e-8; ///< of loads that vary: half an interval's change of the force
};

const std::vector<Case> cases{
    {{"initial.velocity=[\"0\", \"-1\"]"}, 0.1, 1},
    {{"initial.velocity=[\"0\", \"-1\"]", "load.body=[\"0\", \"-1\"]"}, std::sqrt(1.2) - 1, std::sqrt(1.2)},
    {{"load.gravity=[0, -2]"}, std::sqrt(0.1), 2 * std::sqrt(0.1)},
    {{"load.body=[\"0\", \"-6*t\"]"}, std::cbrt(0.1), 3 * std::pow(0.1, 2 / 3.0), 1e-4},
    {{"contact.obstacle.point=[0, \"-0.1 + 0.5*t\"]"}, 0.2, 0.5},
    {{"contact.obstacle.point=[0, \"-0.1 + 0.5*t\"]", "clamp=[{ on=\"top\" }]"}, 0.2, 0.5},
    {{"initial.velocity=[\"0.5 - y\", \"x - 0.5\"]"}, 0.2, 0.5}, // spins: a corner comes down by t/2
    {{"initial.velocity=[\"0\", \"-1\"]", "clamp=[{ on=\"top\", components=[\"x\"] }]"}, 0.1, 1},
    {{"initial.velocity=[\"0\", \"-1\"]", "initial.displacement=[\"0\", \"-0.05\"]"}, 0.05, 1},
    {{"initial.velocity=[\"0\", \"-1\"]", "mesh.degree=2", "time.step=\"auto\""}, 0.1, 1},
    {{"contact.obstacle.point=[0, 0]"}, 0, 0}};

} // namespace

TEST_CASE("a rigid body first touches when closed forms say so", "[forward]") {
  for (const Case& one : cases) {
    INFO(one.settings.front());
    const trajectory::FirstTouch found = touch(one.settings);
    CHECK(found.flies);
    CHECK(std::abs(found.time - one.time) <= one.tolerance);
    CHECK(std::abs(found.speed - one.speed) <= std::max(one.tolerance, 1e-8));
  }
  // Thrown up by 1 m/s under 4 m/s² it falls back to where it was in half a second, and 0.1 m more.
  const trajectory::FirstTouch back = touch({"initial.velocity=[\"0\", \"1\"]", "load.gravity=[0, -4]"});
  CHECK(std::abs(back.time - (1 + std::sqrt(1.8)) / 4) < 1e-8);
  // Nearest at the turn, 0.1 − 0.3²/(2·0.9), and never there.
  const trajectory::FirstTouch turns = touch({"initial.velocity=[\"0\", \"-0.3\"]", "load.gravity=[0, 0.9]"});
  CHECK((!turns.occurs() && turns.flies));
  CHECK(std::abs(turns.nearest - 0.05) < 1e-8);
  CHECK(std::abs(turns.nearest_time - 1 / 3.0) < 1e-8);
  const trajectory::FirstTouch clamped = touch({"clamp=[{ on=\"top\" }]", "load.gravity=[0, -1]"});
  CHECK((!clamped.flies && !clamped.occurs() && std::abs(clamped.gap - 0.1) < 1e-12));
}

TEST_CASE("the first touch of a run is the one that was foreseen", "[forward]") {
  for (const Settings& settings :
       {cases[0].settings, cases[2].settings, cases[3].settings, cases[4].settings}) {
    CAPTURE(settings);
    const test::Ready ready("tests/data/block.toml", above_floor(settings));
    const problem::Problem& problem = ready.problem;
    diagnostics::ObstacleForces forces(problem.stepper);
    double first = -1;
    trajectory::integrate(problem.stepper, problem.grid, problem.initial, problem.load(),
                          [&](const trajectory::Frame& frame) {
                            forces.observe(frame);
                            if (first < 0 && forces.all().normal_force > 0)
                              first = frame.step.end;
                          });
    const double foreseen = trajectory::first_touches(problem.stepper, ready.scene).at(0).time;
    REQUIRE(first > 0);
    CHECK((first > foreseen - 1e-9 && first - foreseen < 2 * ready.scene.time.step));
  }
}

TEST_CASE("a parabola is zero where its formula says, or never", "[forward]") {
  constexpr double never = std::numeric_limits<double>::infinity();
  struct Parabola {
    double g, v, a, root;
  };
  for (const auto& [g, v, a, root] : {Parabola{-1, 5, 5, 0}, // below zero from the start
                                      {1, -1, 0, 1},
                                      {1, 0.5, 0, never}, // leaves
                                      {1, 0, 0.5, never},
                                      {0.1, 0.5, 0.5, never},
                                      {1, 0, -2, 1},
                                      {1, 1, -4, 1}, // turns
                                      {0.75, -1, 0.5, 1},
                                      {1, -1, 1, never}}) { // turns before
    INFO(g << " + " << v << " s + " << a << " s²/2");
    const double found = trajectory::first_root(g, v, a);
    CHECK((found == root || std::abs(found - root) < 1e-14));
  }
}

TEST_CASE("steps foresee the touch of an obstacle that moves", "[forward]") {
  // The sooner of two, at 0.2 s and at 0.4 s: looked for in ever longer intervals, the last of which begins
  // after half of the time.
  const auto moving = [](const std::string& name, double speed) {
    return fmt::format("{{ name=\"{0}\", shape=\"half-space\", point=[0, \"-0.1 + {1}*t\"], normal=[0, 1] }}",
                       name, speed);
  };
  const std::string two =
      fmt::format("contact=[{{ on=\"bottom\", obstacle={} }}, {{ on=\"bottom\", obstacle={} }}]",
                  moving("slow", 0.25), moving("fast", 0.5));
  for (const auto& [obstacles, time] : {std::pair{"contact.obstacle=" + moving("fast", 0.5), 0.2},
                                        {"contact.obstacle=" + moving("slow", 0.25), 0.4},
                                        {two, 0.2}}) {
    INFO(obstacles);
    const test::Ready ready("tests/data/block.toml", above_floor({obstacles, "time.step=\"auto\""}));
    trajectory::StepErrors errors(ready.problem.stepper, ready.scene);
    errors.start(ready.problem.initial.y(), ready.problem.initial.v());
    errors.set_acceleration(std::vector<double>(errors.rigid().count(), 0));
    const trajectory::Approach approach(ready.problem.stepper, ready.scene, errors);
    const double foreseen = approach.until_touch(0);
    CHECK(foreseen <= time);
    CHECK(foreseen >= 0.45 * time);
  }
}

TEST_CASE("the first touch in words", "[forward]") {
  CHECK(line(cases[0].settings) == "first touch of \"floor\": at 0.1 s with 1 m/s, by the rigid motion from "
                                   "a gap of 0.1 m, without the control");
  CHECK_THAT(line({}),
             ContainsSubstring("none before 0.6 s by the rigid motion, without the control; gap 0.1 m"));
  CHECK_THAT(line({"clamp=[{ on=\"top\" }]"}),
             ContainsSubstring("only by deformation, since clamps hold the body"));
  CHECK_THAT(line({"contact.obstacle.point=[0, 0]"}), ContainsSubstring("\"floor\": at the start"));
}

TEST_CASE("an obstacle far away is in doubt only where the body does not fly there", "[forward]") {
  const auto warnings = [](const Settings& settings) {
    const test::Ready ready("tests/data/block.toml", settings);
    return diagnostics::body_figures(ready.problem.stepper, ready.scene).warnings;
  };
  // Fifteen times the body away, a drop test: 15 m by a fall from rest take √3 s.
  const Settings drop{"contact.obstacle={ shape=\"half-space\", point=[0, -15], normal=[0, 1] }",
                      "initial.velocity=[\"0\", \"0\"]", "load.gravity=[0, -10]", "load.body=[\"0\", \"0\"]",
                      "time={ end=2, step=0.02 }"};
  CHECK(warnings(drop).empty());
  Settings brief = drop;
  brief.emplace_back("time.end=1.5");
  REQUIRE(warnings(brief).size() == 1);
  CHECK_THAT(warnings(brief).front(),
             ContainsSubstring("the obstacle is 15 m away from the body of 1 m, which") &&
                 ContainsSubstring("does not reach the obstacle until 1.5 s") &&
                 ContainsSubstring("mesh.unit"));
}
