// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/error.h"
#include "fixtures.h"
#include "trajectory/time_integrator.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <fmt/format.h>
#include <optional>

using namespace signorini;
using petsc::check;

namespace {

test::Recorded run(const test::Ready& ready) { return test::Recorded(ready.problem); }

} // namespace

TEST_CASE("a free body falls as Newton says", "[forward]") {
  // No contact before t = 0.1; Newmark's scheme is exact under a constant force.
  const test::Ready ready("tests/data/block.toml", {"time.end=0.08"});
  const test::Recorded trajectory = run(ready);
  petsc::Vector exact = ready.problem.space.vector();
  for (int k = 0; k <= trajectory.steps; ++k) {
    REQUIRE(trajectory.contact[static_cast<std::size_t>(k)].active.empty());
    const double t = ready.problem.grid.time(k);
    ready.problem.space.interpolate(
        scene::Field({"0", fmt::format("{:.17g}", -t - t * t / 2)}, "test", false), 0, exact);
    CHECK(test::difference(trajectory.y[static_cast<std::size_t>(k)], exact) < 1e-14);
  }
}

TEST_CASE("all of a body falls alike under gravity, whatever its density and its scheme", "[forward]") {
  // The weight of each node is its inertia's, massless ones included: no strain, and Newmark's scheme is
  // exact.
  const char* away = "contact.obstacle.point=[0, -100]";
  for (const auto& [file, overrides] :
       {std::pair{"tests/data/two-materials.toml", std::vector<std::string>{away}},
        {"tests/data/two-materials.toml", {away, "mesh.degree=2", "time.scheme=contact-stabilized"}},
        {"tests/data/two-materials.toml", {away, "contact.mass=massless"}},
        {"tests/data/two-materials.toml", {away, "contact.mass=massless", "mesh.degree=2"}},
        {"tests/data/cube.toml", {"contact.obstacle.point=[0, 0, -100]", "contact.mass=massless"}},
        {"tests/data/cube.toml", {"contact.obstacle.point=[0, 0, -100]", "solver.linear=iterative"}}}) {
    const bool space = std::string(file).ends_with("cube.toml");
    std::vector<std::string> settings = overrides;
    settings.insert(settings.end(), {space ? "load={gravity = [0.5, 0, -2]}" : "load={gravity = [0.5, -2]}",
                                     space ? "initial.velocity=[0, 1, 0]" : "initial.velocity=[0, 1]"});
    INFO(file << ", " << overrides.back());
    const test::Ready ready(file, settings);
    const test::Recorded trajectory = run(ready);
    const double T = ready.scene.time.end,
                 tolerance =
                     ready.problem.stepper.solver().tolerance() > 0 ? 1e-9 : 1e-13; // 4e-12, 3e-14 found
    const std::string fallen = fmt::format("{:.17g}", -T * T), across = fmt::format("{:.17g}", T * T / 4),
                      thrown = fmt::format("{:.17g}", T - T * T), flown = fmt::format("{:.17g}", T);
    petsc::Vector exact = ready.problem.space.vector();
    ready.problem.space.interpolate(
        scene::Field(space ? scene::Components{across, flown, fallen} : scene::Components{across, thrown},
                     "test", false),
        0, exact);
    CHECK(test::difference(trajectory.y.back(), exact) < tolerance);
    CHECK(test::largest(exact) > 0.1);
    // Its work is what the body gains, and its resultant the weight.
    const auto& balance = trajectory.balance;
    double work = 0;
    for (const auto& step : balance)
      work += step.external_work;
    CHECK(std::abs(work - balance.back().kinetic_energy + balance.front().kinetic_energy) < 1e-9);
  }
}

TEST_CASE("gravity is the density as a body force, and may change with time", "[forward]") {
  const char* degree = GENERATE(as<const char*>{}, "mesh.degree=1", "mesh.degree=2");
  CAPTURE(degree);
  // Of uniform density: the same vector, and so the same motion and contact.
  const test::Ready force("tests/data/block.toml", {degree, "material.density=3", "load.body=[\"t\", -3]"}),
      gravity("tests/data/block.toml", {degree, "material.density=3", "load={gravity = [\"t/3\", -1]}"});
  const test::Recorded a = run(force), b = run(gravity);
  int touched = 0;
  for (std::size_t k = 0; k < a.contact.size(); ++k) {
    CHECK(test::difference(a.y[k], b.y[k]) < 1e-12); // 1e-14 found
    touched += a.contact[k].count(contact::Status::strong) > 0;
  }
  CHECK(touched > 0);
  CHECK_FALSE(step::SceneLoad(gravity.problem.space, gravity.problem.operators.M, gravity.scene,
                              gravity.problem.stepper.end())
                  .has_density());
}

TEST_CASE("energy, momentum and complementarity hold through contact", "[forward]") {
  for (const std::vector<std::string>& overrides :
       {std::vector<std::string>{},
        {"mesh.degree=2"},
        {"solver.vi=full"},
        {"time.step=0.2"},
        {"contact.mass=massless"},
        {"contact.mass=massless", "mesh.degree=2", "solver.vi=full"},
        {"time.scheme=contact-stabilized"},
        {"time.scheme=contact-stabilized", "mesh.degree=2", "solver.vi=full"}}) {
    const test::Ready ready("tests/data/block.toml", overrides);
    const test::Recorded trajectory = run(ready);
    const auto& balance = trajectory.balance;
    int touched = 0;
    double energy = 0, dissipated = 0;
    for (const auto& step : balance)
      energy = std::max(energy, step.kinetic_energy + step.elastic_energy);
    for (std::size_t k = 1; k < balance.size(); ++k) {
      touched += trajectory.contact[k].count(contact::Status::strong) > 0;
      dissipated += balance[k].viscous_dissipation;
      CHECK(std::abs(balance[k].energy_residual) < 1e-12 * energy);
      CHECK(balance[k].contact_work < 1e-14 * energy);
      CHECK(std::hypot(balance[k].momentum_residual[0], balance[k].momentum_residual[1]) <
            1e-12 * balance[k].momentum_scale);
      CHECK(std::ranges::min(trajectory.contact[k].gap) >= -1e-14);
    }
    CHECK(touched > 0);
    CHECK(dissipated > 0);
  }
}

TEST_CASE("the momentum law notices a velocity that is wrong", "[forward]") {
  const test::Ready ready("tests/data/block.toml");
  const step::Stepper& stepper = ready.problem.stepper;
  diagnostics::Balance weigh(stepper);
  const double off = 0.25, tau = ready.problem.grid.length(5);
  const petsc::Vector shift = ready.problem.space.vector(), moved = petsc::zero_like(shift);
  step::State wrong = stepper.state();
  ready.problem.space.interpolate(scene::Field({"0.25", "0"}, "test", false), 0, shift);
  petsc::check(MatMult(stepper.M(), shift, moved));
  const double mass = petsc::dot(shift, moved) / (off * off);
  int looked = 0;
  trajectory::integrate(
      stepper, ready.problem.grid.first(5), ready.problem.initial, ready.problem.load(),
      [&](const trajectory::Frame& frame) {
        if (frame.step.k < 5) {
          weigh(frame);
          return;
        }
        wrong.copy(frame.after);
        petsc::check(VecAXPY(wrong.v(), 1, shift));
        const auto residual =
            weigh({frame.step, frame.before, frame.load, wrong, frame.contact, frame.last}).momentum_residual;
        CHECK(std::abs(residual[0] - mass * off / tau) < 1e-9 * mass * off / tau);
        CHECK(std::abs(residual[1]) < 1e-9 * mass * off / tau);
        ++looked;
      });
  CHECK(looked == 1);
}

TEST_CASE("a body of two equal materials moves like one of one", "[forward]") {
  const std::string data = "density = 2, young = 80, poisson = 0.3, viscosity = { bulk = 0.1, shear = 0.05 }";
  const test::Ready two("tests/data/two-materials.toml",
                        {"material=[{ on = \"left\", " + data + " }, { on = \"right\", " + data + " }]"}),
      one("tests/data/two-materials.toml", {"material={ " + data + " }"});
  const test::Recorded a = run(two), b = run(one);
  int touched = 0;
  for (std::size_t k = 0; k < a.contact.size(); ++k) {
    touched += a.contact[k].count(contact::Status::strong) > 0;
    CHECK(a.contact[k].active == b.contact[k].active);
    CHECK(test::difference(a.y[k], b.y[k]) < 1e-12 * test::largest(b.y.back()));
  }
  CHECK(touched > 0);
  // And what the materials are makes a difference.
  CHECK(test::difference(run(test::Ready("tests/data/two-materials.toml")).y.back(), b.y.back()) >
        1e-3 * test::largest(b.y.back()));
}

TEST_CASE("without loads and viscosity energy never grows, and is kept without contact", "[forward]") {
  const test::Ready ready("tests/data/manufactured.toml",
                          {"load.body=[\"0\", \"0\"]", "material.viscosity={bulk=0, shear=0}", "time.end=5"});
  const test::Recorded trajectory = run(ready);
  const auto& balance = trajectory.balance;
  const double start = balance.front().kinetic_energy;
  REQUIRE(start > 1);
  for (const auto& step : balance)
    CHECK(std::abs((step.kinetic_energy + step.elastic_energy) / start - 1) < 1e-12);
  CHECK(balance.back().elastic_energy > 0.01 * start);
}

TEST_CASE("a traction pushes with its resultant", "[forward]") {
  // Linear in time and space: the midpoint rule and the interpolation are exact.
  const char* degree = GENERATE(as<const char*>{}, "mesh.degree=1", "mesh.degree=2");
  CAPTURE(degree);
  const test::Ready ready("tests/data/block.toml",
                          {degree, "time.end=0.2", "load={traction=[{on=\"rest\", value=[\"t\", \"y\"]}]}",
                           "initial.velocity=[\"0\", \"0\"]"});
  const test::Recorded trajectory = run(ready);
  for (const auto& contact : trajectory.contact)
    REQUIRE(contact.active.empty());
  petsc::Vector momentum = ready.problem.space.vector();
  check(MatMult(ready.problem.operators.M, trajectory.v.back(), momentum));
  const double T = ready.scene.time.end;
  for (const auto& [direction, exact] : {std::pair{scene::Components{"1", "0"}, 3 * T * T / 2}, // three sides
                                         {{"0", "1"}, (0.5 + 0.5 + 1) * T}}) {
    petsc::Vector unit = ready.problem.space.vector();
    ready.problem.space.interpolate(scene::Field(direction, "test", false), 0, unit);
    CHECK(std::abs(petsc::dot(momentum, unit) / exact - 1) < 1e-11);
  }
}

TEST_CASE("initial states that a clamp or an obstacle forbids are refused", "[forward]") {
  CHECK_THROWS_AS(test::Ready("tests/data/manufactured.toml", {"initial.velocity=[\"1\", \"0\"]"}),
                  UserError);
  CHECK_THROWS_AS(test::Ready("tests/data/block.toml", {"contact.obstacle.point=[0, 0.1]"}), UserError);
  // Of all candidates the first alone, and the last.
  using Catch::Matchers::ContainsSubstring;
  CHECK_THROWS_WITH(test::Ready("tests/data/block.toml",
                                {"contact.obstacle={shape=\"half-space\", point=[0.1, 0], normal=[1, 0.2]}"}),
                    ContainsSubstring("at (0, 0, 0) starts"));
  CHECK_THROWS_WITH(
      test::Ready("tests/data/block.toml",
                  {"contact.obstacle={shape=\"half-space\", point=[0.9, 0], normal=[-1, 0.2]}"}),
      ContainsSubstring("at (1, 0, 0) starts"));
}

TEST_CASE("a solution that is not finite ends the run with its step", "[forward]") {
  for (const char* scene :
       {"tests/data/block.toml", "tests/data/manufactured.toml"}) { // with contact and without
    const test::Ready ready(scene);
    const test::Force poison([&](int k, Vec out) {
      if (k == 3)
        check(VecSet(out, std::numeric_limits<double>::quiet_NaN()));
    });
    INFO(scene);
    try {
      (void)test::Recorded(ready.problem, {ready.problem.space, poison});
      FAIL("NaN went through");
    } catch (const SolverFailure& failure) {
      CHECK(std::string(failure.what()).starts_with("step 3 "));
    }
  }
}

TEST_CASE("a plane that meets a body is a body that meets the plane", "[forward]") {
  // Seen from a frame that moves at (0.3, 0.7) m/s nothing else changes: the body is free, its load is
  // constant.
  const char* solver =
      GENERATE(as<const char*>{}, "solver.vi=condensed", "solver.vi=full", "solver.linear=iterative");
  CAPTURE(solver);
  const test::Ready rest("tests/data/block.toml", {solver, "initial.velocity=[\"0.2\", \"-1\"]"}),
      moving("tests/data/block.toml", {solver, "initial.velocity=[\"0.5\", \"-0.3\"]",
                                       "contact.obstacle.point=[\"0.3*t\", \"-0.1 + 0.7*t\"]"});
  const test::Recorded a = run(rest), b = run(moving);
  petsc::Vector shift = rest.problem.space.vector();
  int touched = 0;
  double force = 0, defect = 0;
  for (std::size_t k = 0; k < a.contact.size(); ++k) {
    const double t = rest.problem.grid.time(static_cast<int>(k));
    rest.problem.space.interpolate(
        scene::Field({fmt::format("{:.17g}", 0.3 * t), fmt::format("{:.17g}", 0.7 * t)}, "test", false), 0,
        shift);
    check(VecAXPY(shift, 1, a.y[k]));
    CHECK(test::difference(shift, b.y[k]) < (rest.problem.stepper.solver().tolerance() > 0 ? 1e-10 : 1e-13));
    CHECK(a.contact[k].active == b.contact[k].active);
    touched += a.contact[k].count(contact::Status::strong) > 0;
    for (std::size_t i = 0; i < a.contact[k].lambda.size(); ++i) {
      force = std::max(force, a.contact[k].lambda[i]);
      defect = std::max(defect, std::abs(a.contact[k].lambda[i] - b.contact[k].lambda[i]));
    }
  }
  CHECK(touched > 5);
  CHECK(defect < 1e-9 * force);
  // At rest the plane takes energy at most; as it moves it pushes.
  const auto work = [](const test::Recorded& trajectory) {
    double largest = 0;
    for (const auto& step : trajectory.balance)
      largest = std::max(largest, step.contact_work);
    return largest;
  };
  CHECK(work(a) < 1e-12);
  CHECK(work(b) > 0.01);
}

TEST_CASE("a stiff body without a clamp lands without the contact set cycling", "[forward]") {
  for (const std::vector<std::string>& overrides :
       {std::vector<std::string>{"material.young=1e7", "mesh.size=0.1"},
        {"material.young=1e9", "mesh.size=0.05"},
        {"material.young=2e11", "material.density=7850", "mesh.size=0.1"}}) {
    const test::Ready ready("tests/data/block.toml", overrides);
    const test::Recorded trajectory = run(ready);
    CHECK(trajectory.steps == ready.problem.steps());
    int touched = 0;
    for (const contact::ContactState& state : trajectory.contact)
      touched += state.count(contact::Status::strong) > 0;
    CHECK(touched > 0);
  }
}

TEST_CASE("a body that is pressed onto the plane in equilibrium stays there", "[forward]") {
  // Plane strain under a pressure p on its top, free to widen: uniform strains, which the mesh has exactly.
  const double p = 2, young = 50, poisson = 0.3, tall = -p * (1 - poisson * poisson) / young,
               wide = p * poisson * (1 + poisson) / young;
  for (const std::vector<std::string>& solver :
       std::vector<std::vector<std::string>>{{"solver.vi=condensed"},
                                             {"solver.vi=full"},
                                             {"solver.linear=iterative"},
                                             {"contact.mass=massless"},
                                             {"time.scheme=contact-stabilized"}}) {
    std::vector<std::string> overrides = solver;
    for (const std::string& setting :
         {std::string("contact.obstacle.point=[0, 0]"), std::string("contact.obstacle.normal=[0, 1]"),
          fmt::format("load={{traction=[{{on=\"top\", value=[\"0\", \"{}\"]}}]}}", -p),
          fmt::format("initial={{displacement=[\"{:.17g}*x\", \"{:.17g}*y\"]}}", wide, tall)})
      overrides.push_back(setting);
    const test::Ready ready("tests/data/block.toml", overrides);
    const test::Recorded trajectory = run(ready);
    REQUIRE(trajectory.steps == 30);
    // Solvers leave their tolerance of each step's displacement, and rounding the digits that a step's
    // stiffness takes.
    const double size = test::largest(trajectory.y.front()),
                 off = solver.front() == "solver.vi=full" ? 1e-7 : 1e-9;
    CHECK(size > 0.03);
    for (std::size_t k = 1; k < trajectory.y.size(); ++k) {
      CHECK(test::difference(trajectory.y[k], trajectory.y.front()) < off * size);
      CHECK(trajectory.contact[k].count(contact::Status::strong) == ready.problem.stepper.pairs()->count());
      CHECK(std::abs(trajectory.balance[k].contact_force[1] / p - 1) < off);
    }
  }
}
