#include "base/error.h"
#include "fixtures.h"
#include "forward/extrapolation.h"
#include "forward/invariants.h"
#include <array>
#include <catch2/catch_test_macros.hpp>
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
    const double t = ready.problem.stepper.grid().time(k);
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
                 tolerance = ready.problem.stepper.solver().tolerance() > 0 ? 1e-9 : 1e-12;
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
  for (const char* degree : {"mesh.degree=1", "mesh.degree=2"}) {
    // Of uniform density: the same vector, and so the same motion and contact.
    const test::Ready force("tests/data/block.toml", {degree, "material.density=3", "load.body=[\"t\", -3]"}),
        gravity("tests/data/block.toml", {degree, "material.density=3", "load={gravity = [\"t/3\", -1]}"});
    const test::Recorded a = run(force), b = run(gravity);
    int touched = 0;
    for (std::size_t k = 0; k < a.contact.size(); ++k) {
      CHECK(test::difference(a.y[k], b.y[k]) < 1e-11);
      touched += a.contact[k].count(contact::Status::strong) > 0;
    }
    CHECK(touched > 0);
    CHECK_FALSE(forward::SceneLoad(gravity.problem.space, gravity.problem.operators.M, *gravity.scene.load,
                                   gravity.problem.stepper.grid())
                    .has_density());
  }
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
  for (const char* degree : {"mesh.degree=1", "mesh.degree=2"}) {
    const test::Ready ready("tests/data/block.toml",
                            {degree, "time.end=0.2", "load={traction=[{on=\"rest\", value=[\"t\", \"y\"]}]}",
                             "initial.velocity=[\"0\", \"0\"]"});
    const test::Recorded trajectory = run(ready);
    for (const auto& contact : trajectory.contact)
      REQUIRE(contact.active.empty());
    petsc::Vector momentum = ready.problem.space.vector();
    check(MatMult(ready.problem.operators.M, trajectory.v.back(), momentum));
    const double T = ready.scene.time.end;
    for (const auto& [direction, exact] :
         {std::pair{scene::Components{"1", "0"}, 3 * T * T / 2}, // three sides
          {{"0", "1"}, (0.5 + 0.5 + 1) * T}}) {
      petsc::Vector unit = ready.problem.space.vector();
      ready.problem.space.interpolate(scene::Field(direction, "test", false), 0, unit);
      CHECK(std::abs(petsc::dot(momentum, unit) / exact - 1) < 1e-11);
    }
  }
}

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
                                      ready.problem.stepper.grid().time(k), exact);
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
  for (const char* linear : {"solver.linear=direct", "solver.linear=iterative"}) {
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
  CHECK(std::abs(test::largest(ready.problem.initial.v) - 0.4500001) < 1e-15);
  CHECK_THROWS_WITH(test::Ready("tests/data/block.toml", start("0.46")),
                    Catch::Matchers::ContainsSubstring("initial.velocity: found a difference of 0.01"));
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
      sum += lambda / ready.problem.stepper.grid().scheme(1).impulse();
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
      Catch::Matchers::ContainsSubstring("same motion where clamps meet"));
  CHECK_NOTHROW(test::Ready("tests/data/block.toml",
                            {"clamp=[{on=\"rest\"}, {on=\"bottom\", components=[\"x\"], value=[\"0\"]}]",
                             "initial.velocity=[\"0\", \"0\"]"}));
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

TEST_CASE("the velocity of clamps is known at any step, whatever was asked before", "[forward]") {
  const test::Ready ready("tests/data/manufactured.toml",
                          {"clamp=[{on=\"boundary\", value=[\"0.3*t^2\", \"0.2*x*t\"]}]",
                           "initial.velocity=[\"0\", \"0.2*x\"]", "load.body=[\"0\", \"0\"]"});
  const forward::Stepper& stepper = ready.problem.stepper;
  REQUIRE(stepper.motion());
  forward::PrescribedMotion::At at = stepper.motion()->storage();
  petsc::Vector exact = ready.problem.space.vector(), moving = ready.problem.space.vector();
  for (const int k : {4, 1, 0, 3}) {
    stepper.motion()->evaluate(2, at);
    stepper.motion()->evaluate(k, at);
    const double t = stepper.grid().time(k);
    ready.problem.space.interpolate(scene::Field({fmt::format("{:.17g}", 0.6 * t), "0.2*x"}, "test", false),
                                    0, moving);
    check(VecZeroEntries(exact));
    stepper.motion()->copy(moving, exact);
    CHECK(test::difference(at.velocity, exact) < 1e-9);
  }
}

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
    const double t = ready.problem.stepper.grid().time(k), rate = t <= 0.3 ? 0.1 : 0.7;
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

TEST_CASE("the margins of a motion are those of the step that is nearest to other active sets", "[forward]") {
  using contact::Status;
  forward::Margins margins;
  CHECK(margins.force() == 0);
  contact::ContactState state(4);
  state.status = {Status::open, Status::strong, Status::strong, Status::open};
  state.gap = {0.3, 0, 0, 0.2};
  state.lambda = {0, 5, 8, 0};
  margins.take(state);
  state.lambda = {0, 2, 4, 0};
  state.gap = {0.1, 0, 0, 0.7};
  margins.take(state);
  state.lambda = {0, 3, 6, 0};
  state.gap = {0.4, 0, 0, 0.5};
  margins.take(state);
  CHECK(margins.force() == 2.0 / 8);
  CHECK(margins.gap == 0.1);
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
        Same{obstacle(R"("ball", center=[0.55, "t/2"], radius="0.7 - t/2", side="inside")"),
             obstacle(R"("ball", center=[0.55, )" + series + R"(], radius="0.7 - t/2", side="inside")")},
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
    const double middle = -0.5 + 2 * ready.problem.stepper.grid().time(static_cast<int>(k));
    double force = 0, moment = 0;
    for (std::size_t i = 0; i < motion.contact[k].lambda.size(); ++i) {
      force += motion.contact[k].lambda[i];
      moment += motion.contact[k].lambda[i] * x[3 * i];
    }
    if (middle < -0.2 || middle > 1.2) { // half the chord of 0.01 m is 0.14 m
      CHECK(force == 0);
      continue;
    }
    if (middle < 0.25 || middle > 0.75 || force == 0)
      continue;
    ++inside;
    CHECK(std::abs(moment / force - middle) < 0.15);
  }
  CHECK(inside >= 20); // of 25 steps
}

TEST_CASE("a plane that meets a body is a body that meets the plane", "[forward]") {
  // Seen from a frame that moves at (0.3, 0.7) m/s nothing else changes: the body is free, its load is
  // constant.
  for (const char* solver : {"solver.vi=condensed", "solver.vi=full", "solver.linear=iterative"}) {
    const test::Ready rest("tests/data/block.toml", {solver, "initial.velocity=[\"0.2\", \"-1\"]"}),
        moving("tests/data/block.toml", {solver, "initial.velocity=[\"0.5\", \"-0.3\"]",
                                         "contact.obstacle.point=[\"0.3*t\", \"-0.1 + 0.7*t\"]"});
    const test::Recorded a = run(rest), b = run(moving);
    petsc::Vector shift = rest.problem.space.vector();
    int touched = 0;
    double force = 0, defect = 0;
    for (std::size_t k = 0; k < a.contact.size(); ++k) {
      const double t = rest.problem.stepper.grid().time(static_cast<int>(k));
      rest.problem.space.interpolate(
          scene::Field({fmt::format("{:.17g}", 0.3 * t), fmt::format("{:.17g}", 0.7 * t)}, "test", false), 0,
          shift);
      check(VecAXPY(shift, 1, a.y[k]));
      CHECK(test::difference(shift, b.y[k]) <
            (rest.problem.stepper.solver().tolerance() > 0 ? 1e-10 : 1e-13));
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
}

TEST_CASE("contact where a clamp holds one component, at rest or moving", "[forward]") {
  for (const auto& [motion, velocity] : {std::pair{"0", "0"}, {"0.3*t", "0.3"}}) {
    const auto with = [&](const char* solver) {
      return std::vector<std::string>{
          solver, "contact.on=boundary", fmt::format("initial.velocity=[\"{}\", \"-1\"]", velocity),
          fmt::format("clamp=[{{on=\"left\", components=[\"x\"], value=[\"{}\"]}}]", motion)};
    };
    const test::Ready condensed("tests/data/block.toml", with("solver.vi=condensed")),
        full("tests/data/block.toml", with("solver.vi=full")),
        iterative("tests/data/block.toml", with("solver.linear=iterative"));
    const contact::ContactPairs& pairs = *condensed.problem.stepper.pairs();
    REQUIRE(pairs.held());
    const test::Recorded a = run(condensed), b = run(full), c = run(iterative);
    bool touched = false; // by a node that the clamp holds in part
    for (std::size_t k = 0; k < a.y.size(); ++k) {
      CHECK(test::difference(a.y[k], b.y[k]) < 1e-12 * test::largest(a.y.back()));
      CHECK(test::difference(a.y[k], c.y[k]) < 1e-9 * test::largest(a.y.back()));
      CHECK(std::ranges::min(a.contact[k].gap) > -1e-14);
      for (int i : a.contact[k].active) {
        const auto j = static_cast<std::size_t>(i);
        const bool in_part = pairs.directions()[2 * j] == 0;
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

TEST_CASE("the next state is guessed by the parabola through the last three", "[forward]") {
  const test::Ready ready("tests/data/block.toml", {"solver.linear=iterative"}),
      direct("tests/data/block.toml", {"solver.linear=direct"});
  const fem::Space& space = ready.problem.space;
  const petsc::Vector a = test::smooth(space, 1), b = test::smooth(space, 2), c = test::smooth(space, 3);
  const auto at = [&](double k, double linear, double square) {
    petsc::Vector x = petsc::copy(a);
    check(VecAXPY(x, linear * k, b));
    check(VecAXPY(x, square * k * k, c));
    return x;
  };
  forward::Extrapolation guesses(ready.problem.stepper), copy(ready.problem.stepper),
      none(direct.problem.stepper);
  petsc::Vector out = petsc::copy(c);
  guesses.guess(out);
  CHECK(test::difference(out, c) == 0); // nothing is known
  for (const auto& [linear, square] :
       {std::pair{0.0, 0.0}, {1.0, 0.0}, {-0.3, 0.2}}) { // one, two, three are known
    guesses.forget();
    const int known = 1 + (linear != 0) + (square != 0);
    for (int k = 0; k < known; ++k)
      guesses.remember(at(k, linear, square));
    guesses.guess(out);
    CHECK(test::difference(out, at(known, linear, square)) < 1e-14);
    copy.take(guesses);
    check(VecZeroEntries(out));
    copy.guess(out);
    CHECK(test::difference(out, at(known, linear, square)) < 1e-14);
  }
  for (int k = 3; k < 6; ++k) { // the last three, and no more
    guesses.guess(out);
    CHECK(test::difference(out, at(k, -0.3, 0.2)) < 1e-14);
    guesses.remember(at(k, -0.3, 0.2));
  }
  copy.forget();
  check(VecCopy(c, out));
  copy.guess(out);
  CHECK(test::difference(out, c) == 0);
  none.remember(a);
  none.guess(out);
  CHECK(test::difference(out, c) == 0); // which a direct solver does not need
  CHECK(forward::Extrapolation::vectors(ready.problem.stepper) == 3);
  CHECK(forward::Extrapolation::vectors(direct.problem.stepper) == 0);
}

TEST_CASE("defects of a motion are weighed by what the run has seen", "[forward]") {
  const test::Ready ready("tests/data/block.toml");
  const forward::Stepper& stepper = ready.problem.stepper;
  const petsc::Vector zero = ready.problem.space.vector();
  const double length = ready.problem.space.mesh().diameter();
  const auto m = static_cast<std::size_t>(stepper.pairs()->count());
  forward::Invariants invariants(stepper);
  int k = 0;
  const auto observe = [&](const forward::StepBalance& balance, const contact::ContactState& contact) {
    invariants.observe({++k, zero, zero, {}, zero, zero, contact, false}, balance);
  };
  const contact::ContactState open(static_cast<int>(m));
  contact::ContactState pressed = open;
  pressed.lambda[1] = 4;
  // The scales: energy 3 + 1, forces 8, contact force 4. No defect.
  observe({.kinetic_energy = 3, .elastic_energy = 1, .momentum_scale = 8}, pressed);
  CHECK_FALSE(invariants.violation(0));
  CHECK(invariants.largest_energy() == 4);
  const auto is = [&](const std::array<double, 5>& now) {
    double worst = 0;
    for (std::size_t j = 0; j < now.size(); ++j) {
      worst = std::max(worst, now[j]);
      if (now[j] > 0) { // the worst so far, by the order of the cases
        CHECK(std::abs(invariants.defects()[j].worst / now[j] - 1) < 1e-14);
        CHECK(invariants.defects()[j].step == k);
        const auto said = invariants.violation(0.9 * now[j]);
        REQUIRE(said);
        CHECK(said->starts_with(invariants.defects()[j].name));
        CHECK(said->find(fmt::format("{:.2e}", now[j])) != std::string::npos);
      }
    }
    CHECK_FALSE(invariants.violation(1.1 * worst));
    CHECK(std::abs(invariants.momentum() - now[1]) <= 1e-14 * now[1]);
    CHECK(std::abs(invariants.complementarity() - std::max({now[2], now[3], now[4]})) <= 1e-14 * worst);
  };
  observe({.kinetic_energy = 1, .energy_residual = -0.02}, open); // against the largest energy, not this one
  is({0.005, 0, 0, 0, 0});
  observe({.momentum_residual = {0.02, -0.03, 0.06}, .momentum_scale = 1}, open);
  is({0, 0.07 / 8, 0, 0, 0});
  contact::ContactState inside = open, adhering = open, apart = open;
  inside.gap[m - 1] = -0.001 * length;
  observe({}, inside);
  is({0, 0, 0.001, 0, 0});
  adhering.lambda[0] = -0.004;
  observe({}, adhering);
  is({0, 0, 0, 0.001, 0});
  apart.lambda[2] = 2;
  apart.gap[2] = 0.004 * length;
  observe({}, apart);
  is({0, 0, 0, 0, 0.002});
  // Only the last frame's count, and the worst of them is told.
  observe({}, open);
  CHECK_FALSE(invariants.violation(0));
  CHECK(invariants.defects()[2].step == k - 3);
  adhering.lambda[0] = -0.04;
  adhering.gap[3] = -0.002 * length;
  observe({.energy_residual = 0.004}, adhering);
  CHECK(invariants.violation(1e-3)->starts_with(invariants.defects()[3].name));
  // What is not a number is worst, whatever else is bad beside or after it.
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  contact::ContactState lost = open;
  lost.gap[0] = nan, lost.gap[1] = -length, lost.lambda[2] = -1;
  observe({.energy_residual = 1e3}, lost);
  CHECK(invariants.violation(1e300)->starts_with(invariants.defects()[2].name));
  CHECK(std::isnan(invariants.complementarity()));
  observe({.energy_residual = nan}, inside);
  CHECK(invariants.violation(1e300)->starts_with(invariants.defects()[0].name));
  observe({}, inside);
  CHECK(invariants.violation(0)->starts_with(invariants.defects()[2].name)); // of the last frame
  for (const std::size_t j : {0, 2}) {
    CHECK(std::isnan(invariants.defects()[j].worst));
    CHECK(invariants.defects()[j].step == k - (j == 0 ? 1 : 2));
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
                                    ready.problem.stepper.grid().time(k), exact);
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
  CHECK(test::difference(started.problem.initial.v, exact) < 1e-9);
}

TEST_CASE("the scale of the momentum balance adds the moduli of its terms", "[forward]") {
  const test::Ready ready("tests/data/block.toml");
  const forward::Stepper& stepper = ready.problem.stepper;
  const fem::Space& space = ready.problem.space;
  const double tau = stepper.grid().tau;
  const petsc::Vector y0 = test::smooth(space, 1), y1 = test::smooth(space, 2), v0 = test::smooth(space, 3),
                      v1 = test::smooth(space, 4), density = test::smooth(space, 5);
  contact::ContactState contact(stepper.pairs()->count());
  for (std::size_t i = 0; i < contact.lambda.size(); ++i)
    contact.lambda[i] = 1e-4 * (1 + static_cast<double>(i));
  const auto product = [&](Mat matrix, Vec x) {
    petsc::Vector out = space.vector();
    check(MatMult(matrix, x, out));
    return out;
  };
  const auto length_of_sum = [&](Vec x) {
    std::array<double, 2> sum{};
    for (std::size_t c = 0; c < 2; ++c) {
      petsc::Vector unit = space.vector();
      space.interpolate(scene::Field({c == 0 ? "1" : "0", c == 1 ? "1" : "0"}, "test", false), 0, unit);
      sum[c] = petsc::dot(x, unit);
    }
    return std::hypot(sum[0], sum[1]);
  };
  const auto all = [](Vec x) {
    PetscReal sum = 0;
    check(VecNorm(x, NORM_1, &sum));
    return sum;
  };
  petsc::Vector change = product(stepper.M(), v1), pushes = space.vector();
  check(VecAXPY(change, -1, product(stepper.M(), v0)));
  contact::NormalOperator(*stepper.pairs())
      .add(-1 / stepper.grid().scheme(1).impulse(), contact.lambda, pushes);
  const double exact = length_of_sum(change) / tau +
                       length_of_sum(product(*ready.problem.operators.W, density)) + length_of_sum(pushes) +
                       all(product(ready.problem.operators.A, y1)) + all(product(stepper.M(), v1)) / tau;
  forward::Balance weigh(stepper);
  (void)weigh({0, nullptr, nullptr, {}, y0, v0, contact, false});
  const forward::StepBalance balance = weigh({1, y0, v0, {{.density = density}}, y1, v1, contact, true});
  CHECK(std::abs(balance.momentum_scale / exact - 1) < 1e-12);
  CHECK(std::abs(std::hypot(balance.contact_force[0], balance.contact_force[1]) / length_of_sum(pushes) - 1) <
        1e-12);
}
