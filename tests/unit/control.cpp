// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/check/check.h"
#include "fixtures.h"
#include "optimize/span.h"
#include <algorithm>
#include <array>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <numeric>
#include <random>

using namespace signorini;

namespace {

control::Control some(const control::ControlSpace& controls, int which) {
  control::Control u = controls.zero();
  for (int k = 1; k <= controls.steps(); ++k)
    axpy(1, petsc::ReadArray(test::smooth(controls.space(), which + k)), u.at(k));
  return u;
}

} // namespace

TEST_CASE("the product is that of L2(0,T; L2)", "[control]") {
  const test::Ready ready("tests/data/block.toml");
  const problem::ControlProblem problem(ready.problem, test::silent());
  const control::Control u = problem.controls.interpolate({"2", "t"}, "test"),
                         one = problem.controls.interpolate({"0", "1"}, "test");
  const double T = ready.scene.time.end;
  CHECK(std::abs(problem.controls.product(one, one) / T - 1) < 1e-12);
  CHECK(std::abs(problem.controls.product(u, one) / (T * T / 2) - 1) < 1e-12); // midpoint rule, exact for t
}

TEST_CASE("clipping is the projection in the metric of a bounded control", "[control]") {
  const char* degree = GENERATE(as<const char*>{}, "mesh.degree=1", "mesh.degree=2");
  CAPTURE(degree);
  const test::Ready ready("tests/data/block.toml",
                          {"control.lower=-0.4", "control.upper=[0.3, 0.6]", degree});
  const problem::ControlProblem problem(ready.problem, test::silent());
  const control::Control u = some(problem.controls, 0);
  control::Control clipped = u;
  problem.controls.project(clipped);
  control::Control residual = u;
  residual.add(-1, clipped);
  REQUIRE(problem.controls.inner(residual, residual) > 0);
  // ⟨u − Pu, w − Pu⟩ ≤ 0 for every admissible w characterises the projection.
  for (int which = 1; which < 6; ++which) {
    control::Control w = some(problem.controls, 3 * which);
    problem.controls.project(w);
    w.add(-1, clipped);
    CHECK(problem.controls.inner(residual, w) <= 1e-14);
  }
  // Both metrics weigh constants alike, and represent the same functional.
  const control::Control one = problem.controls.interpolate({"1", "0"}, "test");
  CHECK(std::abs(problem.controls.inner(one, one) / problem.controls.product(one, one) - 1) < 1e-12);
  control::Control g = some(problem.controls, 7);
  const double functional = problem.controls.product(g, u);
  problem.controls.to_inner(g);
  CHECK(std::abs(problem.controls.inner(g, u) - functional) < 1e-12 * std::abs(functional));
}

TEST_CASE("a first guess that is not written is moved into the bounds too", "[control]") {
  const test::Ready bounded("tests/data/block.toml", {"control.lower=[0.5, -3]", "control.upper=[1, -0.25]"}),
      loaded("tests/data/block.toml", {"load.body=[\"0.5\", \"-1.25\"]"}), free("tests/data/block.toml");
  const auto density = [](const test::Ready& ready) {
    const problem::GivenControl given(ready.problem);
    return petsc::copy(given.load().at(ready.problem.grid.step(1)).density);
  };
  CHECK(test::difference(density(bounded), density(loaded)) == 0);
  CHECK(test::difference(density(bounded), density(free)) == 0.5);
}

TEST_CASE("a control that changes in time pushes by its mean over each step", "[control]") {
  const bool chosen = GENERATE(false, true); // then it is evaluated step by step
  const test::Ready ready("tests/data/block.toml",
                          {"load.body=[\"0\", \"0\"]", "control.initial=[\"sin(9*t)\", \"sin(9*t)\"]",
                           chosen ? "time={end=0.6, step=\"auto\", tolerance=1e-2}" : "time.step=0.02"});
  const problem::GivenControl given(ready.problem);
  const int k = GENERATE(1, 2, 17, 3);
  CAPTURE(k);
  const step::TimeStep step =
      chosen ? step::TimeStep{k, 0.02 * (k - 1), 0.02 * k, 0.02} : ready.problem.grid.step(k);
  const double mean = (std::cos(9 * step.begin) - std::cos(9 * step.end)) / (9 * step.tau);
  const petsc::Vector density = petsc::copy(given.load().at(step).density);
  petsc::check(VecShift(density, -mean));
  CHECK(test::largest(density) < 1e-12);
}

TEST_CASE("J is the trapezoidal rule of its integrals", "[control]") {
  // No motion at all: y = 0, y_d = (t, 0): tracking ½∫t² by the trapezoidal rule, terminal γT².
  const test::Ready ready("tests/data/block.toml",
                          {"objective.desired={displacement=[\"t\", \"0\"]}", "load.body=[\"0\", \"0\"]",
                           "initial.velocity=[\"0\", \"0\"]"});
  problem::ControlProblem problem(ready.problem, test::silent());
  problem.reduced.simulate(problem.controls.zero());
  problem.reduced.accept();
  const double T = ready.scene.time.end, tau = ready.scene.time.step;
  const control::ObjectiveValue& value = problem.reduced.value();
  CHECK(std::abs(value.tracking / (T * T * T / 6 + tau * tau * T / 12) - 1) < 1e-12);
  CHECK(std::abs(value.terminal / (ready.scene.objective->gamma * T * T) - 1) < 1e-12);
  CHECK(value.control_cost == 0);
}

TEST_CASE("at the reference control only the cost of the control is left", "[control]") {
  const test::Ready ready("tests/data/block.toml");
  problem::ControlProblem problem(ready.problem, test::silent());
  problem.reduced.simulate(*problem.reference);
  problem.reduced.accept();
  const control::ObjectiveValue& value = problem.reduced.value();
  // Not exactly: on several ranks MUMPS sums in no fixed order, so that two runs differ by rounding.
  CHECK(value.tracking < 1e-24);
  CHECK(value.terminal < 1e-24);
  CHECK(std::abs(value.control_cost / (ready.scene.objective->alpha / 2 * 1.09 * ready.scene.time.end) - 1) <
        1e-12);
  control::Control g = problem.reduced.gradient().u;
  g.add(-ready.scene.objective->alpha, *problem.reference);
  CHECK(problem.controls.norm(g) < 1e-12);
}

TEST_CASE("derivatives are exact for every kind of control and objective", "[control]") {
  const std::string one_component = "objective.desired={control=[\"0\", \"-1\"]}";
  for (const std::vector<std::string>& overrides : std::vector<std::vector<std::string>>{
           {},
           {"control.space=cellwise"},
           {"control.on=rest", "control.scale=0.5"},
           {"control.on=rest", "control.space=cellwise", "control.scale=0.5"},
           {"control.constant_in_time=true"},
           {"control.components=[\"y\"]", one_component},
           {"control.components=[\"y\"]", "control.space=cellwise", "control.constant_in_time=true",
            one_component},
           {"control.on=rest", "mesh.degree=2", "mesh.size=0.5", "control.constant_in_time=true"},
           {"objective.on=rest"},
           {"objective.tracking=0", "objective.gamma=1"},
           {"objective.gamma=0", "objective.alpha=0", "objective.on=rest"},
           {"clamp=[{on=\"rest\", value=[\"0\", \"-0.3*t\"]}]", "initial={displacement=[\"0\", \"0\"]}",
            "time.end=1"}}) {
    std::string what;
    for (const std::string& setting : overrides)
      what += setting + " ";
    INFO(what);
    test::Ready ready("tests/data/block.toml", overrides);
    CHECK(drivers::check_scene(ready.problem, test::silent()));
  }
}

TEST_CASE("a control holds values where it acts and nowhere else", "[control]") {
  const auto values = [](const std::vector<std::string>& overrides) {
    const test::Ready ready("tests/data/block.toml", overrides);
    const problem::Problem& problem = ready.problem;
    const control::ControlSpace controls(problem.space, problem.operators, problem.grid,
                                         *ready.scene.control);
    const control::Control u = controls.interpolate({"1 + x", "2 + y*y"}, "test");
    petsc::Vector field = controls.field(), rest = controls.field();
    std::vector<double> back(controls.size());
    controls.extend(u.at(2), field);
    controls.restrict(field, back);
    CHECK(test::difference(back, u.at(2)) == 0);
    controls.extend(back, rest);
    CHECK(test::difference(field, rest) == 0);
    PetscScalar sum = 0;
    PetscReal extended = 0;
    double own = std::transform_reduce(u.at(2).begin(), u.at(2).end(), 0.0, std::plus(),
                                       [](double x) { return std::abs(x); });
    MPI_Allreduce(MPI_IN_PLACE, &own, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    petsc::check(VecNorm(field, NORM_1, &extended));
    petsc::check(VecSum(field, &sum));
    CHECK(std::abs(own - extended) <= 1e-12 * own);
    CHECK(std::abs(sum - own) <= 1e-12 * own); // positive where it acts
    const auto size = static_cast<PetscInt>(test::total(static_cast<long>(controls.size())));
    PetscInt whole = 0;
    petsc::check(VecGetSize(field, &whole));
    return std::array<PetscInt, 2>{size, whole};
  };
  const std::string y = "control.components=[\"y\"]",
                    given = "objective.desired={displacement=[\"0\", \"0\"]}";
  const auto [all, nodes] = values({});
  CHECK(all == nodes);
  CHECK(values({y, given})[0] == nodes / 2);
  constexpr PetscInt per_side = 4; // cells, of size 0.25
  CHECK(values({"control.on=bottom"})[0] == 2 * (per_side + 1));
  CHECK(values({"control.on=bottom", y, given})[0] == per_side + 1);
  const auto [cells_on, cells] = values({"control.on=bottom", "control.space=cellwise"});
  CHECK(cells_on == 2 * per_side);
  CHECK(cells > 4 * cells_on);
}

TEST_CASE("a control pushes with its resultant where it acts", "[control]") {
  for (const char* on : {"", "rest"})
    for (const char* kind : {"nodal", "cellwise"}) {
      CAPTURE(on, kind);
      std::vector<std::string> overrides{fmt::format("control.space={}", kind), "control.scale=2"};
      if (*on)
        overrides.push_back(fmt::format("control.on={}", on));
      const test::Ready ready("tests/data/block.toml", overrides);
      const problem::Problem& problem = ready.problem;
      const control::ControlSpace controls(problem.space, problem.operators, problem.grid,
                                           *ready.scene.control);
      const control::Control u = controls.interpolate({"0", "3"}, "test");
      const double size = *on ? 3 : 1; // three sides, or the square
      CHECK(std::abs(controls.product(u, u) / (9 * size * ready.scene.time.end) - 1) < 1e-12);
      const control::ControlForce pushes(controls, u);
      petsc::Vector force = problem.space.vector();
      step::assemble(step::ForceAtStep(problem.space, pushes).at(problem.grid.step(1)), problem.operators,
                     force);
      PetscScalar sum = 0;
      petsc::check(VecSum(force, &sum));
      CHECK(std::abs(sum / (2 * 3 * size) - 1) < 1e-12);
    }
}

TEST_CASE("the gradient by a control constant in time is the mean of that by steps", "[control]") {
  const auto gradient = [](bool constant, auto&& use) {
    const test::Ready ready("tests/data/block.toml",
                            {"control.constant_in_time=" + std::string(constant ? "true" : "false")});
    problem::ControlProblem problem(ready.problem, test::silent());
    problem.reduced.simulate(problem.controls.constant(-0.5));
    problem.reduced.accept();
    use(problem.reduced.gradient().u);
  };
  std::vector<double> mean;
  gradient(false, [&](const control::Control& g) {
    mean.assign(g.at(1).size(), 0);
    for (int k = 1; k <= g.count(); ++k)
      axpy(1.0 / g.count(), g.at(k), mean);
    CHECK(test::difference(g.at(1), mean) > 0.1 * test::largest(mean));
  });
  gradient(true, [&](const control::Control& g) {
    CHECK(g.count() == 1);
    CHECK(test::difference(g.at(1), mean) < 1e-11 * test::largest(mean));
  });
}

TEST_CASE("a rejected trial changes nothing", "[control]") {
  const test::Ready ready("tests/data/block.toml");
  problem::ControlProblem problem(ready.problem, test::silent());
  const control::Control u = some(problem.controls, 0), other = some(problem.controls, 4);
  const double value = problem.reduced.value(u);
  problem.reduced.accept();
  const control::Control before = problem.reduced.gradient().u;
  problem.reduced.simulate(other);
  control::Control after = problem.reduced.gradient().u;
  after.add(-1, before);
  CHECK(problem.controls.norm(before) > 0);
  CHECK(problem.controls.norm(after) < 1e-12 * problem.controls.norm(before));
  CHECK(problem.reduced.value().total() == value);
}

TEST_CASE("what pushes out of a bound is held there, each component by its own", "[control]") {
  const test::Ready ready("tests/data/block.toml",
                          {"control.lower=[-0.4, -0.2]", "control.upper=[0.3, 0.6]"});
  const problem::ControlProblem problem(ready.problem, test::silent());
  const control::ControlSpace& controls = problem.controls;
  constexpr std::array lower{-0.4, -0.2}, upper{0.3, 0.6};
  // Values at, beside and beyond both bounds of both components, with directions of either sign and none.
  constexpr std::array values{-0.4, -0.2, 0.3, 0.6, -0.5, 0.7, 0.1, -0.3, 0.4};
  constexpr std::array directions{-1.0, 0.5, 0.0, 2.0, -0.1};
  control::Control u = controls.zero(), d = controls.zero(), w = controls.constant(3);
  for (int k = 1; k <= u.count(); ++k) {
    const std::span<double> at = u.at(k), to = d.at(k);
    for (std::size_t i = 0; i < at.size(); ++i) {
      at[i] = values[(i / 2 + static_cast<std::size_t>(k)) % values.size()];
      to[i] = directions[(i / 3 + 2 * static_cast<std::size_t>(k)) % directions.size()];
    }
  }
  controls.zero_blocked(w, u, d);
  long held = 0, wrong = 0;
  for (int k = 1; k <= u.count(); ++k) {
    const std::span<const double> at = u.at(k), to = d.at(k), out = w.at(k);
    for (std::size_t i = 0; i < at.size(); ++i) {
      const bool holds = (at[i] <= lower[i % 2] && to[i] < 0) || (at[i] >= upper[i % 2] && to[i] > 0);
      held += holds;
      wrong += out[i] != (holds ? 0 : 3);
    }
  }
  CHECK(test::total(held) > 100);
  CHECK(test::total(wrong) == 0);
  controls.project(u);
  long outside = 0, moved = 0;
  for (int k = 1; k <= u.count(); ++k) {
    const std::span<const double> at = u.at(k);
    for (std::size_t i = 0; i < at.size(); ++i) {
      const double before = values[(i / 2 + static_cast<std::size_t>(k)) % values.size()];
      outside += at[i] != std::clamp(before, lower[i % 2], upper[i % 2]);
      moved += at[i] != before;
    }
  }
  CHECK(test::total(outside) == 0);
  CHECK(test::total(moved) > 100);
}

TEST_CASE("a search stores controls in single precision, whatever their units", "[control]") {
  const test::Ready ready("tests/data/block.toml");
  const problem::ControlProblem problem(ready.problem, test::silent());
  const control::ControlSpace& controls = problem.controls;
  constexpr double rounding = 1.2e-7; // 2^-23: of half a unit in the last place of each value
  for (const double unit : {1e-60, 1.0, 1e60}) {
    INFO("in units of " << unit);
    std::vector<control::CompactControl> stored;
    std::vector<control::Control> given, widened;
    for (int i = 0; i < 7; ++i) { // not a multiple of what one pass takes
      given.push_back(some(controls, i));
      given.back().scale(unit);
      stored.emplace_back(given.back());
      widened.emplace_back(stored.back());
      control::Control difference = widened.back();
      difference.add(-1, given.back());
      const double size = controls.norm(given.back());
      REQUIRE(size > 0);
      CHECK(controls.norm(difference) <= rounding * size);
      CHECK(controls.norm(difference) > 0); // it was rounded
      CHECK(std::ranges::equal(control::Control(control::CompactControl(widened.back())).values(),
                               widened.back().values())); // once
    }
    const std::vector<double> factors{1, -2, 3, 0, 0.5, -1, 2};
    control::Control sum = given.front(), expected = given.front();
    sum.add(factors, stored);
    for (std::size_t i = 0; i < stored.size(); ++i)
      expected.add(factors[i], widened[i]);
    sum.add(-1, expected);
    CHECK(controls.norm(sum) <= 1e-14 * controls.norm(expected));
    const std::vector<control::Control> duals{controls.dual(given[1]), controls.dual(given[2])};
    const std::vector<double> products = controls.pairings(duals, stored);
    for (std::size_t i = 0; i < duals.size(); ++i)
      for (std::size_t j = 0; j < stored.size(); ++j)
        CHECK(std::abs(products[i * stored.size() + j] - controls.inner(given[i + 1], widened[j])) <=
              1e-13 * controls.norm(given[i + 1]) * controls.norm(widened[j]));
  }
}

TEST_CASE("a subspace of controls in single precision is that of what was given, however often restricted",
          "[control][optimize]") {
  const test::Ready ready("tests/data/block.toml");
  const problem::ControlProblem problem(ready.problem, test::silent());
  const control::ControlSpace& controls = problem.controls;
  optimize::Span<control::ControlSpace> span(10 * std::numeric_limits<float>::epsilon());
  std::mt19937 random(5);
  const auto any = [&] {
    control::Control v = controls.zero();
    std::ranges::generate(v.values(), [&] { return std::normal_distribution()(random); });
    return v;
  };
  const control::Control given = any();
  optimize::Coordinates held = span.coordinates(controls, given);
  for (int time = 0; time < 30; ++time) {
    const control::Control factors = any();
    control::Control v = any();
    std::vector<optimize::Coordinates> found;
    for (int i = 0; i < 24; ++i) { // as by products with a Hessian: V is ill conditioned
      control::Control unlike = v; // in length
      unlike.scale(std::pow(10, -i % 7));
      found.push_back(span.coordinates(controls, unlike));
      std::ranges::transform(v.values(), factors.values(), v.values().begin(),
                             [](double x, double y) { return x * (1 + 0.3 * y); });
    }
    REQUIRE(span.dimension() > 12);
    optimize::Orthonormal part(1e-12);
    REQUIRE(part.take({&held}, 1));
    for (const optimize::Coordinates& x : found)
      part.take({&x}, 12);
    span.restrict(part.vectors());
    REQUIRE(span.dimension() == 12);
    held = part.of(held);
    control::Control back = span.vector(held, given);
    back.add(-1, given);
    CHECK(controls.norm(back) <= 1e-6 * controls.norm(given)); // 2^-24 each time
    for (std::size_t i = 0; i < span.dimension(); ++i) {
      optimize::Coordinates unit(i + 1);
      unit[i] = 1;
      CHECK(std::abs(controls.norm(span.vector(unit, given)) - 1) <= 1e-5);
    }
  }
}

TEST_CASE("a vector that is hardly out of a restricted subspace adds a direction at right angles to it",
          "[control]") {
  const test::Ready ready("tests/data/block.toml");
  const problem::ControlProblem problem(ready.problem, test::silent());
  const control::ControlSpace& controls = problem.controls;
  const double single = std::numeric_limits<float>::epsilon();
  optimize::Span<control::ControlSpace> span(10 * single);
  std::mt19937 random(6);
  const auto any = [&] {
    control::Control v = controls.zero();
    std::ranges::generate(v.values(), [&] { return std::normal_distribution()(random); });
    return v;
  };
  const control::Control like = any();
  std::vector<optimize::Coordinates> found;
  for (int i = 0; i < 12; ++i)
    found.push_back(span.coordinates(controls, any()));
  optimize::Orthonormal part(1e-12);
  for (int i = 0; i < 8; ++i)
    part.take({&found[static_cast<std::size_t>(i)]}, 8);
  span.restrict(part.vectors());
  REQUIRE(span.dimension() == 8);
  control::Control v = span.vector(optimize::Coordinates(8, 1.0), like);
  for (int i = 0; i < 8; ++i) { // each is out of what there is by twenty times what single precision leaves
    control::Control beside = any();
    beside.scale(20 * single * controls.norm(v) / controls.norm(beside));
    v.add(1, beside);
    const optimize::Coordinates x = span.coordinates(controls, v);
    control::Control back = span.vector(x, like);
    back.add(-1, v);
    CHECK(controls.norm(back) <= 20 * single * controls.norm(v));
    CHECK(std::abs(optimize::norm(x) / controls.norm(v) - 1) <= 1e-6);
  }
  REQUIRE(span.dimension() > 12);
  std::vector<control::Control> basis;
  for (std::size_t i = 0; i < span.dimension(); ++i) {
    optimize::Coordinates unit(i + 1);
    unit[i] = 1;
    basis.push_back(span.vector(unit, like));
    for (std::size_t j = 0; j <= i; ++j)
      CHECK(std::abs(controls.inner(basis[i], basis[j]) - (i == j)) <= 1e-4);
  }
}
