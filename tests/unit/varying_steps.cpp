// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/collective.h"
#include "diagnostics/balance.h"
#include "fixtures.h"
#include "trajectory/step_control.h"
#include <catch2/catch_test_macros.hpp>
#include <set>

using namespace signorini;
using petsc::check;

namespace {

/// A block that falls for two seconds, hits the floor and is thrown back, in steps that the motion chooses.
const std::vector<std::string> falling{"contact.obstacle.point=[0, -4.1]", "load={gravity=[\"0\", \"-1\"]}",
                                       "time={end=4, step=\"auto\", tolerance=1e-2}"};

std::vector<std::string> with(std::vector<std::string> overrides, const std::vector<std::string>& more) {
  overrides.insert(overrides.end(), more.begin(), more.end());
  return overrides;
}

const std::vector<std::vector<std::string>> schemes{
    {}, {"time.scheme=\"contact-stabilized\""}, {"contact.mass=massless"}, {"mesh.degree=2"}};

/// One that a clamp holds above the floor, and that swings onto it: when it touches, no rigid motion
/// foresees.
const std::vector<std::string> held{"clamp=[{on=\"top\"}]", "contact.obstacle.point=[0, -0.3]",
                                    "initial.velocity=[\"0\", \"0\"]", "load={body=[\"0\", \"-20\"]}",
                                    "time={end=40, step=\"auto\", tolerance=1e-1}"};

/// Chooses the lengths by the scene's own motion, which touches.
void choose(problem::Problem& problem) { problem::choose_steps(problem, problem.load(), test::silent()); }

/// By how much two equal motions and their gradients differ, relative: MUMPS, on several ranks, does not give
/// the same bits twice, and contact multiplies what one step leaves, to 2e-9 in the worst of 25 runs on three
/// ranks. Where a wrong state is read they differ by a part of a step's motion.
double rounding() { return ranks(MPI_COMM_WORLD) == 1 ? 0 : 1e-8; }

std::set<double> lengths(const step::TimeGrid& grid) {
  std::set<double> all;
  for (int k = 1; k <= grid.steps(); ++k)
    all.insert(grid.length(k));
  return all;
}

} // namespace

TEST_CASE("steps of a ladder begin at multiples of their length and end where the motion does", "[forward]") {
  const double end = 0.7; // no binary fraction
  const step::StepLengths step_lengths(end, 3, 4);
  step::TimeGridBuilder builder(step_lengths);
  CHECK(step_lengths.length(0) == end / 3);
  CHECK_FALSE(builder.complete());
  std::vector<double> levels;
  std::vector<step::TimeStep> steps;
  for (const int level : {0, 2, 3, 4, 4, 2, 2, 1, 3, 3, 2}) {
    CAPTURE(level);
    REQUIRE(level >= builder.least_level());
    builder.add(step_lengths.levels);
    builder.remove(); // without a trace
    steps.push_back(builder.add(level));
    levels.push_back(level);
  }
  CHECK(builder.least_level() == 0); // they make up three longest ones
  const step::TimeGrid grid = builder.grid();
  CHECK(grid.complete());
  CHECK(grid.time(grid.steps()) == end);
  CHECK(grid.levels() == levels);
  for (int k = 1; k <= grid.steps(); ++k) {
    const double tau = grid.length(k);
    CHECK(tau == step_lengths.length(static_cast<int>(levels[static_cast<std::size_t>(k) - 1])));
    const step::TimeStep step = grid.step(k), &added = steps[static_cast<std::size_t>(k) - 1];
    CHECK((step.k == k && step.begin == grid.time(k - 1) && step.end == grid.time(k) && step.tau == tau));
    CHECK((added.k == k && added.begin == step.begin && added.end == step.end && added.tau == tau));
    CHECK(std::abs(grid.time(k - 1) + tau - grid.time(k)) < 1e-15);
    CHECK(std::abs(std::remainder(grid.time(k - 1), tau)) < 1e-15);
    const step::TimeGrid::Place middle = grid.place(grid.middle(k));
    CHECK((middle.k == k && std::abs(middle.part - 0.5) < 1e-12));
  }
  CHECK(grid.place(0).k == 1);
  CHECK(grid.place(end).k == grid.steps());
  const auto taken = [&](const std::vector<double>& some) {
    return step::TimeGrid::of_levels(step_lengths, some);
  };
  REQUIRE(taken(levels));
  CHECK(taken(levels)->levels() == levels);
  CHECK_FALSE(taken({0, 2, 1, 0, 0})); // the third begins at no multiple of its length
  CHECK_FALSE(taken({0, 0}));          // too short
  CHECK_FALSE(taken({0, 0, 0, 0}));    // too long
  CHECK_FALSE(taken({0, 0, 5}));       // no such length
  const step::TimeGrid first = grid.first(4);
  CHECK((first.steps() == 4 && !first.complete() && first.time(4) == grid.time(4)));
  builder.remove();
  CHECK((grid.complete() && !builder.complete() && builder.grid().steps() == grid.steps() - 1));
}

TEST_CASE("motions in steps of varying length keep the laws of energy and momentum", "[forward]") {
  std::vector<std::vector<std::string>> scenes = schemes;
  scenes.push_back(held);
  int rejected = 0;
  for (const std::vector<std::string>& scene : scenes) {
    const test::Ready ready("tests/data/block.toml", with(falling, scene));
    const problem::Problem& problem = ready.problem;
    diagnostics::Balance weigh(problem.stepper);
    trajectory::StepControl control(problem.stepper, ready.scene);
    double energy = 0, off = 0, force = 0, momentum = 0;
    int touching = 0, last = -1;
    const step::TimeGrid grid = trajectory::integrate_choosing(
        problem.stepper, problem.initial, problem.load(), control, [&](const trajectory::Frame& frame) {
          CHECK(frame.step.k == last + 1); // repeated steps are not shown
          last = frame.step.k;
          const diagnostics::StepBalance balance = weigh(frame);
          energy = std::max(energy, balance.kinetic_energy + balance.elastic_energy);
          off = std::max(off, std::abs(balance.energy_residual));
          force = std::max(force, balance.momentum_scale);
          momentum =
              std::max(momentum, std::hypot(balance.momentum_residual[0], balance.momentum_residual[1]));
          touching += !frame.contact.active.empty();
          CHECK(balance.contact_work <= 1e-12 * energy);
        });
    CHECK(grid.complete());
    CHECK(grid.steps() == last);
    REQUIRE(touching > 3);
    REQUIRE(lengths(grid).size() > 1);
    rejected += control.rejected();
    CHECK(off < 1e-11 * energy);
    CHECK(momentum < 1e-10 * force);
    // The same motion again, of the steps that were chosen.
    petsc::Vector end = problem.space.vector();
    trajectory::integrate(problem.stepper, grid, problem.initial, problem.load(),
                          [&](const trajectory::Frame& frame) { check(VecCopy(frame.after.y(), end)); });
    const petsc::Vector first = petsc::copy(end);
    trajectory::integrate(problem.stepper, grid, problem.initial, problem.load(),
                          [&](const trajectory::Frame& frame) { check(VecCopy(frame.after.y(), end)); });
    CHECK(test::difference(first, end) <= rounding() * test::largest(end));
  }
  CHECK(rejected > 0); // and not shown
}

TEST_CASE("chosen steps do not depend on the units of mass and time", "[forward]") {
  // Factors are powers of two, so that every digit is the same. The energy at the start is 1/2 J and 8 J.
  const std::vector<std::string> other{"material.density=64",
                                       "material.young=800",
                                       "material.viscosity={bulk=1.6, shear=1.6}",
                                       "load={gravity=[\"0\", \"-0.25\"]}",
                                       "initial.velocity=[\"0\", \"-0.5\"]",
                                       "time={end=8, step=\"auto\", tolerance=1e-2}"};
  for (const std::vector<std::string>& scheme : schemes)
    for (const char* quantity :
         {"time.quantity=displacement", "time.quantity=contact-force", "time.quantity=energy"}) {
      INFO(quantity << (scheme.empty() ? "" : ", " + scheme.back()));
      std::vector<std::vector<double>> levels;
      std::vector<int> touching;
      for (const std::vector<std::string>& units : {std::vector<std::string>{}, other}) {
        const test::Ready ready("tests/data/block.toml",
                                with(with(with(falling, units), scheme), {quantity}));
        const problem::Problem& problem = ready.problem;
        trajectory::StepControl control(problem.stepper, ready.scene);
        touching.push_back(0);
        const step::TimeGrid grid = trajectory::integrate_choosing(
            problem.stepper, problem.initial, problem.load(), control,
            [&](const trajectory::Frame& frame) { touching.back() += !frame.contact.active.empty(); });
        levels.push_back(grid.levels());
        REQUIRE(lengths(grid).size() > 1);
      }
      REQUIRE(touching[0] > 3);
      CHECK(touching[0] == touching[1]);
      CHECK(levels[0] == levels[1]);
    }
}

TEST_CASE("a factor that memory has no room for is made again, to the same motion", "[forward]") {
  std::vector<petsc::Vector> ends;
  std::vector<int> made;
  std::optional<test::Ready> kept;
  for (const char* memory : {"solver.memory=1e9", "solver.memory=1e3"}) {
    const test::Ready ready("tests/data/block.toml", with(falling, {"solver.linear=direct", memory}));
    const problem::Problem& problem = ready.problem;
    trajectory::StepControl control(problem.stepper, ready.scene);
    petsc::Vector& end = ends.emplace_back(problem.space.vector());
    (void)trajectory::integrate_choosing(
        problem.stepper, problem.initial, problem.load(), control,
        [&](const trajectory::Frame& frame) { check(VecCopy(frame.after.y(), end)); });
    made.push_back(problem.stepper.factorisations());
  }
  CHECK(made[1] > made[0]);
  CHECK(test::difference(ends[0], ends[1]) <= rounding() * test::largest(ends[0]));
}

TEST_CASE("stored motions of varying steps come back the same from memory, disk and checkpoints",
          "[forward]") {
  std::vector<std::vector<double>> gradients;
  for (const std::vector<std::string>& storage :
       {std::vector<std::string>{"trajectory.storage=memory"},
        {"trajectory.storage=disk"},
        {"trajectory.storage=checkpoints", "trajectory.budget=2e5"}}) {
    test::Ready ready("tests/data/block.toml", with(falling, storage));
    choose(ready.problem);
    problem::ControlProblem problem(ready.problem, test::silent());
    problem.reduced.simulate(problem.controls.constant(-0.3));
    problem.reduced.accept();
    const control::Control g = problem.reduced.gradient().u;
    gradients.emplace_back(g.values().begin(), g.values().end());
    REQUIRE(lengths(ready.problem.grid).size() > 1);
  }
  for (const std::vector<double>& other : {gradients[1], gradients[2]})
    CHECK(test::difference(other, gradients[0]) <= rounding() * test::largest(gradients[0]));
}

TEST_CASE("a control on intervals of its own sees the mean of the gradients of their steps", "[control]") {
  // Three intervals of four steps: the values of a step are those of its interval.
  const std::vector<std::string> time{"time={end=0.24, step=0.02}"};
  std::vector<double> mean;
  {
    const test::Ready ready("tests/data/block.toml", time);
    problem::ControlProblem problem(ready.problem, test::silent());
    problem.reduced.simulate(problem.controls.constant(-0.5));
    problem.reduced.accept();
    const control::Control g = problem.reduced.l2_gradient();
    REQUIRE(g.count() == 12);
    const std::size_t n = g.at(1).size();
    mean.resize(3 * n);
    for (int k = 1; k <= 12; ++k)
      for (std::size_t i = 0; i < n; ++i)
        mean[static_cast<std::size_t>((k - 1) / 4) * n + i] += g.at(k)[i] / 4;
  }
  const test::Ready ready("tests/data/block.toml", with(time, {"control.step=0.08"}));
  problem::ControlProblem problem(ready.problem, test::silent());
  problem.reduced.simulate(problem.controls.constant(-0.5));
  problem.reduced.accept();
  const control::Control g = problem.reduced.l2_gradient();
  REQUIRE(g.count() == 3);
  double largest = 0, off = 0;
  for (std::size_t i = 0; i < mean.size(); ++i) {
    largest = std::max(largest, std::abs(mean[i]));
    off = std::max(off, std::abs(g.values()[i] - mean[i]));
  }
  CHECK(largest > 0);
  CHECK(off < 1e-12 * largest);
  CHECK(problem.controls.begin(2) == 0.08);
  CHECK(std::abs(problem.controls.product(g, g) -
                 (problem.controls.product_at(1, g, g) + problem.controls.product_at(2, g, g) +
                  problem.controls.product_at(3, g, g)) *
                     0.08) < 1e-12 * problem.controls.product(g, g));
}

TEST_CASE("steps chosen by the energy are judged by that of their errors", "[forward]") {
  // A free block that vibrates, of an energy far from 1.
  for (const char* velocity :
       {"initial.velocity=[\"0.02*x - 0.01\", \"-0.05*y\"]", "initial.velocity=[\"2*x - 1\", \"-5*y\"]"}) {
    const test::Ready ready("tests/data/block.toml",
                            {"contact.obstacle.point=[0, -100]", "load={body=[\"0\", \"0\"]}", velocity,
                             "time={end=40, step=\"auto\", tolerance=1e-1, quantity=\"energy\"}"});
    const problem::Problem& problem = ready.problem;
    const Mat A = problem.stepper.operators().A;
    trajectory::StepErrors errors(problem.stepper, ready.scene), watching(problem.stepper, ready.scene);
    trajectory::StepControl control(problem.stepper, ready.scene);
    const petsc::Vector Ax = problem.space.vector();
    const auto energy = [&](Vec x) {
      check(MatMult(A, x, Ax));
      return petsc::dot(Ax, x);
    };
    std::vector<petsc::Vector> y;
    double largest = 0;
    int judged = 0;
    const double shortest = problem.stepper.step_lengths()->shortest_step();
    std::vector<double> lengths{0};
    (void)trajectory::integrate_choosing(
        problem.stepper, problem.initial, problem.load(), control, [&](const trajectory::Frame& frame) {
          y.push_back(petsc::copy(frame.after.y()));
          largest = std::max(largest, energy(frame.after.y()));
          watching.observe(frame);
          if (frame.step.k == 0)
            return errors.start(frame.after.y(), frame.after.v());
          const double error = errors.judge(frame).error;
          errors.accept(frame);
          const auto k = static_cast<std::size_t>(frame.step.k);
          lengths.push_back(frame.step.tau);
          if (k < 3 || lengths[k] == shortest || lengths[k] != lengths[k - 2] || lengths[k] != lengths[k - 1])
            return;
          const petsc::Vector third = petsc::copy(y[k]);
          check(VecAXPY(third, -3, y[k - 1]));
          check(VecAXPY(third, 3, y[k - 2]));
          check(VecAXPY(third, -1, y[k - 3]));
          const double expected = std::sqrt(energy(third)) / 12;
          if (expected < 1e-6 * errors.scale()) // rounding is taken off
            return;
          CHECK(std::abs(error / expected - 1) < 1e-6);
          CHECK(std::abs(errors.error_of(third, y[k]) / expected - 1) < 1e-6);
          ++judged;
        });
    CHECK(judged > 5);
    // The rigid motion has no energy: to the rounding that is left of it.
    CHECK(std::abs(errors.scale() / std::sqrt(largest) - 1) < 1e-6);
    CHECK(std::abs(control.errors().scale() / errors.scale() - 1) < 1e-12);
    CHECK(std::abs(watching.scale() / errors.scale() - 1) < 1e-12);
  }
}

TEST_CASE("steps of any lengths have no error where velocity is linear in time", "[forward]") {
  const test::Ready ready("tests/data/block.toml", {"contact.obstacle.point=[0, -100]",
                                                    "time={end=4, step=\"auto\", tolerance=1e-2}"});
  const step::Stepper& stepper = ready.problem.stepper;
  const petsc::Vector shape = test::smooth(ready.problem.space, 1), zero = ready.problem.space.vector();
  const contact::ContactState open = stepper.contact_state();
  const auto largest_error = [&](double power) {
    trajectory::StepErrors errors(stepper, ready.scene);
    step::TimeGridBuilder steps(*stepper.step_lengths());
    step::State before = stepper.state(), after = stepper.state();
    errors.start(zero, zero);
    double most = 0;
    for (const int level : {2, 2, 3, 3, 2, 1, 1}) {
      const step::TimeStep step = steps.add(level);
      check(VecAXPBY(after.y(), std::pow(step.end, power), 0, shape));
      const double error = errors.judge({step, &before, {}, after, open, false}).error;
      errors.accept({step, &before, {}, after, open, false});
      if (step.k > 2) // the first has no mean velocity before it
        most = std::max(most, error / errors.size(after.y()));
      std::swap(before, after);
    }
    return most;
  };
  CHECK(largest_error(2) < 1e-12);
  CHECK(largest_error(3) > 1e-3);
}

TEST_CASE("errors of steps in contact that are longer than the shortest add up to a warning", "[forward]") {
  // It comes to rest on the floor.
  const std::vector<std::string> resting{
      "contact.obstacle={shape=\"half-space\", point=[0, -0.1], normal=[0, 1]}",
      "material.viscosity={bulk=5, shear=5}", "time={end=40, step=\"auto\", tolerance=1e-1}"};
  const test::Ready ready("tests/data/block.toml", resting),
      strict("tests/data/block.toml", with(resting, {"time.tolerance=1e-6"}));
  const problem::Problem& problem = ready.problem;
  trajectory::StepErrors errors(problem.stepper, strict.scene);
  trajectory::StepControl control(problem.stepper, ready.scene);
  double sum = 0;
  int longer = 0, shortest = 0;
  (void)trajectory::integrate_choosing(
      problem.stepper, problem.initial, problem.load(), control, [&](const trajectory::Frame& frame) {
        if (frame.step.k == 0)
          return errors.start(frame.after.y(), frame.after.v());
        const double error = errors.judge(frame).error;
        errors.accept(frame);
        if (!errors.contact())
          return;
        const step::StepLengths& step_lengths = *problem.stepper.step_lengths();
        (step_lengths.level(frame.step.tau) < step_lengths.levels ? longer : shortest) += 1;
        sum += error; // none of the shortest
      });
  REQUIRE(longer > 3);
  REQUIRE(shortest > 3);
  const std::vector<Warning> warnings = errors.warnings();
  const auto found = std::ranges::find(warnings, "accumulated error", &Warning::name);
  REQUIRE(found != warnings.end());
  CHECK(std::abs(found->value / (sum / errors.scale()) - 1) < 1e-12);
  CHECK(std::abs(found->limit / 5e-6 - 1) < 1e-12);
}
