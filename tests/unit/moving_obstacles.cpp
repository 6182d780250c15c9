// SPDX-License-Identifier: GPL-3.0-or-later
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <fmt/format.h>
#include <optional>

using namespace signorini;

namespace {

test::Recorded run(const test::Ready& ready) { return test::Recorded(ready.problem); }

} // namespace

TEST_CASE("clamps follow a time series with its slopes", "[forward]") {
  // Also where two lines meet between two steps: the velocity at t is the slope before t, at 0 that behind
  // it.
  const test::Ready ready("tests/data/block.toml",
                          {"clamp=[{on=\"top\", value=[{file=\"paths.csv\", column=\"bent\"}, \"0.1*t\"]}]",
                           "initial={}", "time.step=0.04"});
  const test::Recorded trajectory = run(ready);
  REQUIRE(trajectory.steps == 15);
  const auto bent = [](double t) { return t <= 0.3 ? 0.1 * t : 0.03 + 0.7 * (t - 0.3); };
  long held = 0;
  for (int k = 0; k <= trajectory.steps; ++k) {
    const double t = ready.problem.grid.time(k), rate = t <= 0.3 ? 0.1 : 0.7;
    const petsc::ReadArray y(trajectory.y[static_cast<std::size_t>(k)]),
        v(trajectory.v[static_cast<std::size_t>(k)]);
    for (int node = 0; node < ready.problem.space.owned_nodes(); ++node) {
      if (!ready.problem.stepper.clamped().contains(node, 0))
        continue;
      const auto dof = static_cast<std::size_t>(2 * node);
      CHECK(std::abs(y[dof] - bent(t)) < 1e-15);
      CHECK(std::abs(v[dof] - rate) < 1e-14);
      CHECK(std::abs(v[dof + 1] - 0.1) < 1e-12);
      ++held;
    }
  }
  CHECK(test::total(held) == 5 * 16);
}

TEST_CASE("an obstacle that moves is one, however it is written", "[forward]") {
  // A ball that rises below a block held at its top, and one that rolls along below it, each also as a
  // cylinder, as a level set and by a time series.
  const std::string clamp = "clamp=[{on=\"top\"}]", still = "initial={}", light = "load={}",
                    series = "{file=\"paths.csv\", column=\"linear\"}";
  const auto obstacle = [](const std::string& shape) { return "contact.obstacle={shape=" + shape + "}"; };
  using Same = std::vector<std::string>;
  for (const Same& same :
       {Same{obstacle(R"("ball", center=[0.6, "-1.1 + t/2"], radius=1)"),
             obstacle(R"("cylinder", point=[0.6, "-1.1 + t/2"], radius=1)"),
             obstacle(R"("signed-distance", distance="2*sqrt((x - 0.6)^2 + (y + 1.1 - t/2)^2) - 2")")},
        Same{obstacle(R"("ball", center=["-0.5 + 3*t", -0.97], radius=1)"),
             obstacle(R"("signed-distance", distance="sqrt((x + 0.5 - 3*t)^2 + (y + 0.97)^2) - 1")")},
        Same{obstacle(R"("ball", center=[0.6, "t/2"], radius="0.8 - t/2", side="inside")"),
             obstacle(R"("ball", center=[0.6, )" + series + R"(], radius="0.8 - t/2", side="inside")")},
        Same{obstacle(R"("half-space", point=[0, "-0.1 + t/2"], normal=[0.2, 1])"),
             obstacle(R"("signed-distance", distance="0.2*x + y + 0.1 - t/2")")}}) {
    std::optional<test::Recorded> first;
    for (const std::string& shape : same) {
      INFO(shape);
      const test::Ready ready("tests/data/block.toml", {clamp, still, light, shape, "mesh.size=0.125"});
      test::Recorded motion = run(ready);
      if (!first) {
        first.emplace(std::move(motion));
        int touched = 0;
        for (const auto& contact : first->contact)
          touched += contact.count(contact::Status::strong) > 0;
        CHECK((touched > 3 && first->contact.front().active.empty()));
        continue;
      }
      for (std::size_t k = 0; k < motion.y.size(); ++k) {
        CHECK(test::difference(first->y[k], motion.y[k]) < 1e-9); // differences of a level set
        CHECK(first->contact[k].active == motion.contact[k].active);
      }
    }
  }
}

TEST_CASE("a ball that rolls along a body presses where it is", "[forward]") {
  const test::Ready ready("tests/data/block.toml",
                          {"clamp=[{on=\"top\"}]", "initial={}", "load={}", "mesh.size=0.05",
                           "time.scheme=contact-stabilized", "time.end=1", "time.step=0.01",
                           R"(contact.obstacle={shape="ball", center=["-0.5 + 2*t", -0.99], radius=1})"});
  const test::Recorded motion = run(ready);
  const std::vector<double>& x = ready.problem.stepper.pairs()->points();
  int inside = 0;
  for (std::size_t k = 0; k < motion.contact.size(); ++k) {
    const double middle = -0.5 + 2 * ready.problem.grid.time(static_cast<int>(k));
    double force = 0, moment = 0;
    for (std::size_t i = 0; i < motion.contact[k].lambda.size(); ++i) {
      force += motion.contact[k].lambda[i];
      moment += motion.contact[k].lambda[i] * x[3 * i];
    }
    if (middle < -0.2 || middle > 1.2) { // half the chord of 0.01 m is 0.14 m
      CHECK(force == 0);
      continue;
    }
    if (middle < 0.25 || middle > 0.75)
      continue;
    ++inside;
    CHECK(force > 0);
    CHECK(std::abs(moment / force - middle) < 0.15);
  }
  CHECK(inside > 20);
}
