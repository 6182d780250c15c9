// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/error_estimate.h"
#include "accuracy/measure.h"
#include "base/collective.h"
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <fmt/format.h>

using namespace signorini;
using petsc::check;

namespace {

/// J at the first guess of a scene and what is estimated to be its error.
struct Estimated {
  double J;
  adjoint::ErrorParts error;
};

Estimated estimated(const std::string& file, const std::vector<std::string>& overrides, bool contact) {
  const test::Ready ready(file, overrides);
  problem::ControlProblem control_problem(ready.problem, test::silent());
  control_problem.reduced.simulate(control_problem.first_guess(ready.scene));
  control_problem.reduced.accept();
  bool touched = false;
  for (const contact::ContactLinearisation& state : control_problem.reduced.trajectory().contact())
    touched |= !state.active.empty();
  REQUIRE(touched == contact);
  return {control_problem.reduced.value().total(), accuracy::estimate_error(ready.problem, control_problem)};
}

std::vector<std::string> with(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// A block that a smooth force shears and a clamp holds: a linear problem on a domain that every mesh fills.
const std::vector<std::string> sheared{"contact.obstacle.point=[0, -9]",
                                       "initial.velocity=[\"0\", \"0\"]",
                                       "clamp=[{on=\"bottom\"}]",
                                       "contact.on=left",
                                       "load.body=[\"sin(2*t)\", \"y\"]",
                                       "control.initial=[\"0.5*y\", \"cos(t)\"]",
                                       "time.end=0.64"};

} // namespace

TEST_CASE("the error in time is estimated by its first term", "[adjoint]") {
  if (ranks(MPI_COMM_WORLD) > 2)
    return; // a hundred small solves, of which three ranks learn nothing that two do not
  for (const std::vector<std::string>& scheme :
       {std::vector<std::string>{}, {"time.scheme=contact-stabilized"}}) {
    const std::vector<std::string> scene = with(sheared, scheme);
    const auto at = [&](const char* step) {
      return estimated("tests/data/block.toml", with(scene, {step}), false);
    };
    const double exact =
        (4 * at("time.step=0.00125").J - at("time.step=0.0025").J) / 3; // without the first term
    std::vector<double> off;
    for (const char* step : {"time.step=0.02", "time.step=0.01"}) {
      const Estimated run = at(step);
      off.push_back(std::abs(run.error.time / (exact - run.J) - 1));
    }
    CHECK(off[0] < 0.1);
    CHECK(off[1] < off[0]);
  }
}

TEST_CASE("the error of steps of varying length is estimated by its first term", "[adjoint]") {
  if (ranks(MPI_COMM_WORLD) > 2)
    return; // as above
  // Steps of three lengths, halved again and again.
  const auto at = [&](const std::vector<std::string>& scheme, int halvings) {
    test::Ready ready(
        "tests/data/block.toml",
        with(with(sheared, scheme), {"time.step=auto", "time.longest=0.04", "time.tolerance=1e-6"}));
    std::vector<double> levels;
    for (int longest = 0; longest < 16; ++longest) {
      const std::vector<int> all = longest % 3 == 0   ? std::vector{0}
                                   : longest % 3 == 1 ? std::vector{1, 2, 2}
                                                      : std::vector{2, 2, 1};
      for (const int level : all)
        levels.insert(levels.end(), std::size_t(1) << halvings, level + halvings);
    }
    const auto grid = step::TimeGrid::of_levels(*ready.problem.stepper.step_lengths(), levels);
    REQUIRE(grid);
    ready.problem.grid = *grid;
    problem::ControlProblem control_problem(ready.problem, test::silent());
    control_problem.reduced.simulate(control_problem.first_guess(ready.scene));
    control_problem.reduced.accept();
    return Estimated{control_problem.reduced.value().total(),
                     accuracy::estimate_error(ready.problem, control_problem)};
  };
  for (const std::vector<std::string>& scheme :
       {std::vector<std::string>{}, {"time.scheme=contact-stabilized"}}) {
    const double exact = (4 * at(scheme, 3).J - at(scheme, 2).J) / 3;
    std::vector<double> off;
    for (const int halvings : {0, 1}) {
      const Estimated run = at(scheme, halvings);
      off.push_back(std::abs(run.error.time / (exact - run.J) - 1));
      INFO("estimate " << run.error.time << ", error " << exact - run.J);
      CHECK(off.back() < 0.25);
    }
    CHECK(off[1] < off[0]);
  }
}

TEST_CASE("the error in space is estimated beside that of functions of degree 2", "[adjoint]") {
  const auto at = [&](const char* size, const char* degree) {
    return estimated("tests/data/block.toml", with(sheared, {size, degree}), false);
  };
  const double exact = at("mesh.size=0.05", "mesh.degree=2").J;
  std::vector<double> effectivity;
  for (const char* size : {"mesh.size=0.2", "mesh.size=0.1", "mesh.size=0.05"}) {
    const Estimated run = at(size, "mesh.degree=1");
    effectivity.push_back(*run.error.space / (exact - run.J));
    INFO("effectivity " << effectivity.back());
    CHECK((effectivity.back() > 0.5 && effectivity.back() < 2));
  }
  CHECK_FALSE(at("mesh.size=0.2", "mesh.degree=2").error.space);
}

TEST_CASE("what initial data lack by interpolation is estimated as functions of degree 2 make it",
          "[adjoint]") {
  struct Case {
    const char *file, *initial;
    std::vector<std::string> others;
  };
  const std::string control = "control.initial=[\"0.5*y\", \"0.2\"]", wall = "contact.obstacle.point=[0, -9]";
  const std::vector<std::string> plane{wall,
                                       "clamp=[{on=\"bottom\"}]",
                                       "contact.on=left",
                                       control,
                                       "mesh.size=0.1",
                                       "time.step=0.005",
                                       "time.end=0.3",
                                       "objective.desired={displacement=[\"0.3*y\", \"0.2\"]}"};
  const std::vector<std::string> space{
      "contact.obstacle.point=[0, 0, -9]",
      "control={scale=1.0}",
      "time.end=0.2",
      "time.step=0.02",
      "mesh.file=cube-even.geo",
      "objective={gamma=0.05, desired={displacement=[\"0.3*y\", \"0.2\", \"0\"]}}"};
  const std::vector<std::string> stabilized = with(plane, {"time.scheme=contact-stabilized"});
  const char
      *velocity = "initial.velocity=[\"sin(8*x)*sin(2*y)*y\", \"0.5*y\"]",
      *displacement =
          "initial.velocity=[\"0\", \"0\"] initial.displacement=[\"0.02*sin(8*x)*y\", \"0.01*y*cos(6*y)\"]";
  for (const Case& one :
       {Case{"tests/data/block.toml", velocity, plane}, Case{"tests/data/block.toml", velocity, stabilized},
        Case{"tests/data/block.toml", displacement, plane},
        Case{"tests/data/block.toml", displacement,
             with(plane, {"material.viscosity={bulk=0.5, shear=0.5}"})},
        Case{"tests/data/cube.toml",
             "initial.velocity=[\"sin(4*x)*(1-z)\", \"0.2*cos(4*y)\", \"0\"] initial.displacement=[\"0\", "
             "\"0.03*cos(4*y)\", \"0.02*sin(3*z)\"]",
             space}}) {
    const std::string both = one.initial;
    const std::size_t gap = both.find(" initial.");
    std::vector<std::string> scene = with(one.others, {both.substr(0, gap)});
    if (gap != std::string::npos)
      scene.push_back(both.substr(gap + 1));
    // J of functions of degree 2 that start from the data of the run of degree 1, and from their own.
    const auto J = [&](bool interpolated) {
      test::Ready ready(one.file, with(scene, {"mesh.degree=2"}));
      if (interpolated) {
        const fem::Space linear(ready.problem.mesh, 1);
        const petsc::Matrix embed = fem::embedding(linear, ready.problem.space);
        const auto start = [&](const std::optional<scene::Components>& field, Vec x) {
          if (!field)
            return;
          const petsc::Vector values = linear.vector();
          linear.interpolate({*field, "initial", false}, 0, values);
          check(MatMult(embed, values, x));
        };
        start(ready.scene.initial.displacement, ready.problem.initial.y());
        start(ready.scene.initial.velocity, ready.problem.initial.v());
      }
      problem::ControlProblem control_problem(ready.problem, test::silent());
      return control_problem.reduced.value(control_problem.first_guess(ready.scene));
    };
    const double lacks = J(false) - J(true);
    const Estimated run = estimated(one.file, scene, false);
    INFO(one.file << ": estimated " << run.error.initial << ", by functions of degree 2 " << lacks << ", J "
                  << run.J);
    CHECK(std::abs(lacks) > 1e-4 * run.J);
    // Off by the order h² or better: 8.9, 5.0, 3.0, 1.7 % of the cube in 4 to 7 parts a side.
    CHECK(std::abs(run.error.initial / lacks - 1) < 0.05);
  }
}

TEST_CASE("what a desired displacement lacks by interpolation is in the estimate", "[adjoint]") {
  // A body that rests: J = (T/2 + γ) ‖y_d‖², with ∫ sin²(3 x) over the unit interval 1/2 − sin(6)/12.
  const double squared = 0.5 - std::sin(6.0) / 12, T = 0.2, gamma = 0.05;
  struct Case {
    const char *file, *desired, *on;
  };
  for (const Case& one : {Case{"tests/data/block.toml", "[\"sin(3*x)\", \"0\"]", ""},
                          Case{"tests/data/block.toml", "[\"sin(3*x)\", \"0\"]", "on=\"top\", "},
                          Case{"tests/data/cube.toml", "[\"0\", \"0\", \"sin(3*x)\"]", ""}}) {
    const bool plane = std::string(one.file).find("block") != std::string::npos;
    const std::vector<std::string> scene{
        plane ? "contact.obstacle.point=[0, -9]" : "contact.obstacle.point=[0, 0, -9]",
        plane ? "load.body=[\"0\", \"0\"]" : "load.body=[\"0\", \"0\", \"0\"]",
        plane ? "initial.velocity=[\"0\", \"0\"]" : "initial.velocity=[\"0\", \"0\", \"0\"]",
        "control={scale=1.0}",
        fmt::format("objective={{{}gamma={}, desired={{displacement={}}}}}", one.on, gamma, one.desired),
        fmt::format("time.end={}", T),
        "mesh.size=0.2"};
    const Estimated run = estimated(one.file, scene, false);
    const double exact = (T / 2 + gamma) * squared, lacks = exact - run.J;
    INFO(one.file << ": estimated " << run.error.desired << ", in truth " << lacks << " of " << exact);
    CHECK(std::abs(lacks) > 1e-3 * exact);
    CHECK(std::abs(run.error.desired / lacks - 1) <
          0.1); // degree 2 leaves the order 4, here (3 · 0.2)² / 16 or so of it
    CHECK(std::abs(run.error.sum() / lacks - 1) < 0.1);
  }
}

TEST_CASE("interpolated loads are in the estimate in space", "[adjoint]") {
  // What the load that is written down and its interpolation make of J with functions of degree 2.
  const std::vector<std::string> scene =
      with(sheared, {"load.body=[\"5*sin(9*x)*y\", \"-1\"]", "control.initial=[\"0\", \"0\"]",
                     "objective.desired={displacement=[\"0.1*y\", \"0\"]}"});
  const double exact =
      estimated("tests/data/block.toml", with(scene, {"mesh.size=0.04", "mesh.degree=2"}), false).J;
  for (const char* size : {"mesh.size=0.2", "mesh.size=0.1"}) {
    const Estimated run = estimated("tests/data/block.toml", with(scene, {size}), false);
    INFO("effectivity " << *run.error.space / (exact - run.J));
    CHECK(std::abs(*run.error.space / (exact - run.J) - 1) < 0.5);
  }
}

TEST_CASE("parts of an estimate do not make up for each other", "[adjoint]") {
  const adjoint::ErrorParts parts{3e-3, -3e-3, 1e-3, -2e-3};
  CHECK(std::abs(parts.sum() + 1e-3) < 1e-15);
  CHECK(std::abs(parts.sum_of_moduli() - 9e-3) < 1e-15);
}

TEST_CASE("errors in contact are estimated, those of the desired motion included", "[adjoint]") {
  if (ranks(MPI_COMM_WORLD) > 2)
    return; // a hundred small solves, of which three ranks learn nothing that two do not
  for (const std::vector<std::string>& scheme :
       {std::vector<std::string>{}, {"time.scheme=contact-stabilized"}, {"contact.mass=massless"}}) {
    const auto at = [&](const char* size, const char* degree) {
      return estimated("scenes/half-disc.toml",
                       with({size, degree, "control.initial=[\"0\", \"-0.8\"]", "time.step=1e-4"}, scheme),
                       true);
    };
    const double exact = at("mesh.size=0.7", "mesh.degree=2").J;
    const Estimated run = at("mesh.size=1.4", "mesh.degree=1");
    const double effectivity = *run.error.space / (exact - run.J);
    INFO("effectivity " << effectivity);
    CHECK((effectivity > 0.3 && effectivity < 3));
  }
}

TEST_CASE("the error of J is estimated unless the body relaxes", "[adjoint]") {
  const bool relaxes = GENERATE(false, true);
  std::vector<std::string> overrides{"time.end=0.06"};
  if (relaxes)
    overrides.emplace_back("material.prony=[{ g = 0.3, time = 0.1 }]");
  const scene::Scene scene = test::parse(test::source("tests/data/block.toml"), overrides);
  const accuracy::SamplePoints samples(MPI_COMM_WORLD, scene);
  const accuracy::Measured measured = accuracy::measure(MPI_COMM_WORLD, scene, samples, {}, true);
  CHECK(measured.numbers.at("J") > 0);
  CHECK(measured.estimate.has_value() == !relaxes);
  if (relaxes)
    CHECK_THROWS_WITH(
        accuracy::require_estimable(scene, "--accuracy", "leave it out"),
        Catch::Matchers::ContainsSubstring("--accuracy: cannot be combined with material.prony"));
  else
    CHECK_NOTHROW(accuracy::require_estimable(scene, "--accuracy", "leave it out"));
}
