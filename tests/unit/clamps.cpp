// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/pairs.h"
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <fmt/format.h>

using namespace signorini;
using petsc::check;

namespace {

test::Recorded run(const test::Ready& ready) { return test::Recorded(ready.problem); }

} // namespace

TEST_CASE("a body moves with its clamps", "[forward]") {
  // The force that accelerates a rigid body as its boundary moves strains nothing, and Newmark's scheme is
  // exact.
  for (const auto& [setting, tolerance] :
       {std::pair{"solver.linear=direct", 1e-13},
        {"solver.linear=iterative", 1e-9},
        {"solver.vi=full", 1e-7}}) { // SNESVI's relative tolerance, added up
    const test::Ready ready("tests/data/block.toml",
                            {setting, "clamp=[{on=\"rest\", value=[\"t^2/2\", \"0.1*t\"]}]",
                             "load.body=[\"1\", \"0\"]", "initial.velocity=[\"0\", \"0.1\"]"});
    const test::Recorded trajectory = run(ready);
    REQUIRE(trajectory.steps == 30);
    petsc::Vector exact = ready.problem.space.vector();
    for (int k = 0; k <= trajectory.steps; ++k) {
      REQUIRE(trajectory.contact[static_cast<std::size_t>(k)].active.empty());
      ready.problem.space.interpolate(scene::Field({"t^2/2", "0.1*t"}, "test", true),
                                      ready.problem.grid.time(k), exact);
      CHECK(test::difference(trajectory.y[static_cast<std::size_t>(k)], exact) < tolerance);
    }
  }
}

TEST_CASE("a clamp of one component leaves the others free", "[forward]") {
  const test::Ready ready("tests/data/block.toml",
                          {"clamp=[{on=\"rest\", components=[\"y\"]}]", "load.body=[\"1\", \"0\"]",
                           "initial.velocity=[\"0\", \"0\"]"});
  const test::Recorded trajectory = run(ready);
  petsc::Vector exact = ready.problem.space.vector();
  ready.problem.space.interpolate(scene::Field({"t^2/2", "0"}, "test", true), ready.scene.time.end, exact);
  CHECK(test::difference(trajectory.y.back(), exact) < 1e-13);

  const test::Ready sagging("tests/data/block.toml",
                            {"clamp=[{on=\"rest\", components=[\"y\"]}]", "initial.velocity=[\"0\", \"0\"]",
                             "load.body=[\"0\", \"-5\"]"});
  const test::Recorded sag = run(sagging);
  double held = 0, largest = 0;
  {
    const petsc::ReadArray y(sag.y.back());
    for (int node = 0; node < sagging.problem.space.owned_nodes(); ++node) {
      const auto dof = static_cast<std::size_t>(2 * node);
      largest = std::max(largest, std::abs(y[dof + 1]));
      if (sagging.problem.stepper.clamped().contains(node, 1))
        held = std::max(held, std::abs(y[dof + 1]));
      CHECK_FALSE(sagging.problem.stepper.clamped().contains(node, 0));
    }
  }
  CHECK(held == 0);
  CHECK(test::total(largest > 0.01) > 0);
}

TEST_CASE("energy and momentum hold with moving clamps, tractions and contact", "[forward]") {
  const char* linear = GENERATE(as<const char*>{}, "solver.linear=direct", "solver.linear=iterative");
  CAPTURE(linear);
  const test::Ready ready("tests/data/block.toml",
                          {linear, "clamp=[{on=\"rest\", value=[\"0.05*sin(9*t)\", \"-0.3*t\"]}]",
                           "time.end=1", "load.traction=[{on=\"bottom\", value=[\"x*sin(t)\", \"0.1\"]}]",
                           "initial={displacement=[\"0\", \"0\"]}"});
  const test::Recorded trajectory = run(ready);
  const auto& balance = trajectory.balance;
  int touched = 0;
  double energy = 0, work = 0;
  for (const auto& step : balance) {
    energy = std::max(energy, step.kinetic_energy + step.elastic_energy);
    work += step.external_work;
  }
  for (std::size_t k = 1; k < balance.size(); ++k) {
    touched += trajectory.contact[k].count(contact::Status::strong) > 0;
    CHECK(std::abs(balance[k].energy_residual) < 1e-10 * energy);
    CHECK(std::hypot(balance[k].momentum_residual[0], balance[k].momentum_residual[1]) <
          1e-10 * balance[k].momentum_scale);
  }
  CHECK(touched > 2);
  CHECK(std::abs(work) > 0.01 * energy);
}

TEST_CASE("clamps have the velocity of their motion at all times", "[forward]") {
  // They stop within a step, after which neither they nor the body shake; with massless contact, and
  // stabilized, too.
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{}, {"time.scheme=contact-stabilized"}, {"contact.mass=massless"}}) {
    std::vector<std::string> overrides{
        "clamp=[{on=\"rest\", value=[\"0.05*sin(9*min(t, 0.145))\", \"-0.3*min(t, 0.145)\"]}]",
        "initial={displacement=[\"0\", \"0\"]}", "material.viscosity.shear=5"};
    overrides.insert(overrides.end(), more.begin(), more.end());
    const test::Ready ready("tests/data/block.toml", overrides);
    const test::Recorded motion = run(ready);
    const fem::DirichletDofs& clamped = ready.problem.stepper.clamped();
    double energy = 0;
    for (std::size_t k = 0; k < motion.v.size(); ++k) {
      const double t = 0.02 * static_cast<double>(k);
      double worst = 0;
      {
        const petsc::ReadArray v(motion.v[k]);
        for (int node = 0; node < ready.problem.space.owned_nodes(); ++node)
          if (clamped.contains(node, 0)) {
            worst = std::max(worst, std::abs(v[static_cast<std::size_t>(2 * node)] -
                                             (t < 0.145 ? 0.45 * std::cos(9 * t) : 0)));
            worst =
                std::max(worst, std::abs(v[static_cast<std::size_t>(2 * node + 1)] + (t < 0.145 ? 0.3 : 0)));
          }
      }
      MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
      INFO("step " << k);
      if (k != 8) // the step in which they stop
        CHECK(worst < 1e-9);
      energy = std::max(energy, motion.balance[k].kinetic_energy + motion.balance[k].elastic_energy);
      if (k > 0) {
        CHECK(std::abs(motion.balance[k].energy_residual) < 1e-12 * energy);
        CHECK(std::hypot(motion.balance[k].momentum_residual[0], motion.balance[k].momentum_residual[1]) <
              1e-12 * motion.balance[k].momentum_scale);
      }
    }
    CHECK(energy > 0.01);
  }
}

TEST_CASE("an initial velocity written down is kept where clamps move, and must be theirs", "[forward]") {
  const auto start = [](const char* velocity) {
    return std::vector<std::string>{"clamp=[{on=\"rest\", value=[\"0.05*sin(9*t)\", \"-0.3*t\"]}]",
                                    fmt::format("initial={{velocity=[\"{}\", \"-0.3\"]}}", velocity)};
  };
  const test::Ready ready("tests/data/block.toml", start("0.4500001"));
  CHECK(std::abs(test::largest(ready.problem.initial.v()) - 0.4500001) < 1e-15);
  CHECK_THROWS_WITH(test::Ready("tests/data/block.toml", start("0.46")),
                    Catch::Matchers::ContainsSubstring("initial.velocity: found values that differ by 0.01"));
}

TEST_CASE("the force of a frictionless plane is normal to it, also where clamps hold a component",
          "[forward]") {
  const test::Ready ready("tests/data/block.toml",
                          {"clamp=[{on=\"bottom\", components=[\"x\"], value=[\"0.1*t\"]}]",
                           "initial={displacement=[\"0\", \"0\"]}"});
  const test::Recorded motion = run(ready);
  int touched = 0;
  double energy = 0;
  for (std::size_t k = 1; k < motion.balance.size(); ++k) {
    const auto& step = motion.balance[k];
    const auto& force = step.contact_force;
    touched += force[1] > 0.1;
    CHECK(std::abs(force[0] - 0.3 * force[1]) <= 1e-12 * force[1]);
    double sum = 0;
    for (double lambda : motion.contact[k].lambda)
      sum += lambda / ready.problem.grid.scheme(1).impulse();
    CHECK(std::abs(std::hypot(force[0], force[1]) - sum) <= 1e-12 * sum);
    energy = std::max(energy, step.kinetic_energy + step.elastic_energy);
    CHECK(step.contact_work <= 1e-12 * energy); // the plane rests
    CHECK(std::abs(step.energy_residual) < 1e-12 * energy);
    CHECK(std::hypot(step.momentum_residual[0], step.momentum_residual[1]) < 1e-12 * step.momentum_scale);
  }
  CHECK(touched > 2);
}

TEST_CASE("clamps that meet must agree", "[forward]") {
  CHECK_THROWS_WITH(
      test::Ready("tests/data/block.toml", {"clamp=[{on=\"rest\", value=[\"t\", \"0\"]}, {on=\"bottom\", "
                                            "value=[\"2*t\", \"0\"], components=[\"x\", \"y\"]}]"}),
      Catch::Matchers::ContainsSubstring("clamps that share a node must prescribe the same motion"));
  CHECK_NOTHROW(test::Ready("tests/data/block.toml",
                            {"clamp=[{on=\"rest\"}, {on=\"bottom\", components=[\"x\"], value=[\"0\"]}]",
                             "initial.velocity=[\"0\", \"0\"]"}));
}

TEST_CASE("the velocity of clamps is known at any step, whatever was asked before", "[forward]") {
  const test::Ready ready("tests/data/manufactured.toml",
                          {"clamp=[{on=\"boundary\", value=[\"0.3*t^2\", \"0.2*x*t\"]}]",
                           "initial.velocity=[\"0\", \"0.2*x\"]", "load.body=[\"0\", \"0\"]"});
  const step::Stepper& stepper = ready.problem.stepper;
  REQUIRE(stepper.moving_clamps());
  step::MovingClamps::Evaluation at = stepper.moving_clamps()->storage();
  petsc::Vector exact = ready.problem.space.vector(), moving = ready.problem.space.vector();
  const int k = GENERATE(4, 1, 0, 3);
  CAPTURE(k);
  stepper.moving_clamps()->evaluate(ready.problem.grid.step(2), at);
  stepper.moving_clamps()->evaluate(ready.problem.grid.step(k), at);
  const double t = ready.problem.grid.time(k);
  ready.problem.space.interpolate(scene::Field({fmt::format("{:.17g}", 0.6 * t), "0.2*x"}, "test", false), 0,
                                  moving);
  check(VecZeroEntries(exact));
  stepper.moving_clamps()->copy(moving, exact);
  CHECK(test::difference(at.velocity, exact) < 1e-9);
}

TEST_CASE("contact where a clamp holds one component, at rest or moving", "[forward]") {
  for (const auto& [motion, velocity] : {std::pair{"0", "0"}, {"0.3*t", "0.3"}}) {
    CAPTURE(motion, velocity);
    const auto with = [&](const char* solver) {
      return std::vector<std::string>{
          solver, "contact.on=boundary", fmt::format("initial.velocity=[\"{}\", \"-1\"]", velocity),
          fmt::format("clamp=[{{on=\"left\", components=[\"x\"], value=[\"{}\"]}}]", motion)};
    };
    const test::Ready condensed("tests/data/block.toml", with("solver.vi=condensed")),
        full("tests/data/block.toml", with("solver.vi=full")),
        iterative("tests/data/block.toml", with("solver.linear=iterative"));
    const contact::ContactPairs& pairs = *condensed.problem.stepper.pairs();
    REQUIRE(pairs.rows().clamped());
    const test::Recorded a = run(condensed), b = run(full), c = run(iterative);
    bool touched = false; // by a node that the clamp holds in part
    for (std::size_t k = 0; k < a.y.size(); ++k) {
      CHECK(test::difference(a.y[k], b.y[k]) < 1e-12 * test::largest(a.y.back()));
      CHECK(test::difference(a.y[k], c.y[k]) < 1e-9 * test::largest(a.y.back()));
      CHECK(std::ranges::min(a.contact[k].gap) > -1e-14);
      for (int i : a.contact[k].active) {
        const auto j = static_cast<std::size_t>(i);
        const bool in_part = pairs.rows().force(i)[0] == 0;
        CHECK(in_part == (std::abs(pairs.points()[3 * j]) < 1e-12));
        touched |= in_part && a.contact[k].lambda[j] > 0;
        CHECK(std::abs(a.contact[k].gap[j]) < 1e-12);
      }
    }
    CHECK(touched);
    const auto& balance = a.balance;
    double energy = 0;
    for (const auto& step : balance)
      energy = std::max(energy, step.kinetic_energy + step.elastic_energy);
    for (const auto& step : balance)
      CHECK(std::abs(step.energy_residual) < 1e-12 * energy);
  }
}

TEST_CASE("clamps that move strain a body as they say, from node to node", "[forward]") {
  // A homogeneous strain at a constant rate needs no force, and Newmark's scheme is exact.
  const test::Ready ready("tests/data/manufactured.toml",
                          {"load.body=[\"0\", \"0\"]",
                           "clamp=[{on=\"boundary\", value=[\"(0.3*x - 0.1*y)*t\", \"0.2*x*t\"]}]",
                           "initial.velocity=[\"0.3*x - 0.1*y\", \"0.2*x\"]"});
  const test::Recorded trajectory = run(ready);
  petsc::Vector exact = ready.problem.space.vector();
  for (int k = 0; k <= trajectory.steps; ++k) {
    ready.problem.space.interpolate(scene::Field({"(0.3*x - 0.1*y)*t", "0.2*x*t"}, "test", true),
                                    ready.problem.grid.time(k), exact);
    CHECK(test::difference(trajectory.y[static_cast<std::size_t>(k)], exact) < 1e-13);
  }
  CHECK(test::largest(exact) > 0.05);
  // What is not written of the initial velocity is that of the clamps, and rest within.
  const test::Ready started(
      "tests/data/manufactured.toml",
      {"load.body=[\"0\", \"0\"]", "initial={displacement=[\"0\", \"0\"]}",
       "clamp=[{on=\"boundary\", value=[\"(0.3*x - 0.1*y)*t + 2*t^2\", \"0.2*x*t\"]}]"});
  ready.problem.space.interpolate(scene::Field({"0.3*x - 0.1*y", "0.2*x"}, "test", false), 0, exact);
  petsc::Vector inside = petsc::copy(exact);
  ready.problem.stepper.clamped().clear(inside);
  check(VecAXPY(exact, -1, inside));
  CHECK(test::difference(started.problem.initial.v(), exact) < 1e-9);
}
