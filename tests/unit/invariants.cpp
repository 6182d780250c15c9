// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/balance.h"
#include "diagnostics/body_figures.h"
#include "fixtures.h"
#include <array>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <fmt/format.h>

using namespace signorini;
using petsc::check;

TEST_CASE("the margins of a motion are those of the step that is nearest to other active sets", "[forward]") {
  using contact::Status;
  trajectory::Margins margins;
  CHECK(margins.force() == 0);
  contact::ContactState state(4);
  state.status = {Status::open, Status::strong, Status::strong, Status::open};
  state.gap = {0.3, 0, 0, 0.2};
  state.lambda = {0, 5, 8, 0};
  margins.take(state, step::Scheme{0.1});
  state.lambda = {0, 2, 4, 0};
  state.gap = {0.1, 0, 0, 0.7};
  margins.take(state, step::Scheme{0.1});
  state.lambda = {0, 3, 6, 0};
  state.gap = {0.4, 0, 0, 0.5};
  margins.take(state, step::Scheme{0.1});
  CHECK(margins.force() == 2.0 / 8);
  CHECK(margins.gap == 0.1);
}

TEST_CASE("defects of a motion are weighed by what the run has seen", "[forward]") {
  const test::Ready ready("tests/data/block.toml");
  const step::Stepper& stepper = ready.problem.stepper;
  const step::State zero = stepper.state();
  const double length = ready.problem.space.mesh().diameter();
  const auto m = static_cast<std::size_t>(stepper.pairs()->count());
  const diagnostics::BodyFigures body = diagnostics::body_figures(stepper, ready.problem.scene);
  diagnostics::Invariants invariants(stepper, body);
  int k = 0;
  const auto observe = [&](const diagnostics::StepBalance& balance, const contact::ContactState& contact) {
    invariants.observe({ready.problem.grid.step(++k), &zero, {}, zero, contact, false}, balance);
  };
  const contact::ContactState open(static_cast<int>(m));
  contact::ContactState pressed = open;
  // The scales: energy 3 + 1, forces 8, and the contact force of an impact with this energy, of which the
  // pressed node has half. No defect.
  const double meeting =
      std::sqrt(2 * 4 * body.mass) / body.crossing * ready.problem.grid.scheme(1).impulse();
  pressed.lambda[1] = meeting / 2;
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
  adhering.lambda[0] = -0.001 * meeting;
  observe({}, adhering);
  is({0, 0, 0, 0.001, 0});
  apart.lambda[2] = meeting / 2;
  apart.gap[2] = 0.004 * length;
  observe({}, apart);
  is({0, 0, 0, 0, 0.002});
  // Only the last frame's count, and the worst of them is told.
  observe({}, open);
  CHECK_FALSE(invariants.violation(0));
  CHECK(invariants.defects()[2].step == k - 3);
  adhering.lambda[0] = -0.01 * meeting;
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
  const std::size_t j = GENERATE(0, 2);
  CAPTURE(j);
  CHECK(std::isnan(invariants.defects()[j].worst));
  CHECK(invariants.defects()[j].step == k - (j == 0 ? 1 : 2));
}

TEST_CASE("the scale of the momentum balance adds the moduli of its terms", "[forward]") {
  const test::Ready ready("tests/data/block.toml");
  const step::Stepper& stepper = ready.problem.stepper;
  const fem::Space& space = ready.problem.space;
  const double tau = ready.problem.grid.length(1);
  const petsc::Vector y0 = test::smooth(space, 1), y1 = test::smooth(space, 2), v0 = test::smooth(space, 3),
                      v1 = test::smooth(space, 4), density = test::smooth(space, 5);
  const step::State before = stepper.state(), after = stepper.state();
  check(VecCopy(y0, before.y())), check(VecCopy(v0, before.v()));
  check(VecCopy(y1, after.y())), check(VecCopy(v1, after.v()));
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
  stepper.pairs()->rows().apply(-1 / ready.problem.grid.scheme(1).impulse(), contact.lambda, pushes);
  const double exact = length_of_sum(change) / tau +
                       length_of_sum(product(*ready.problem.operators.W, density)) + length_of_sum(pushes) +
                       all(product(ready.problem.operators.A, y1)) + all(product(stepper.M(), v1)) / tau;
  diagnostics::Balance weigh(stepper);
  (void)weigh({ready.problem.grid.step(0), nullptr, {}, before, contact, false});
  const diagnostics::StepBalance balance =
      weigh({ready.problem.grid.step(1), &before, {{.density = density}}, after, contact, true});
  CHECK(std::abs(balance.momentum_scale / exact - 1) < 1e-12);
  CHECK(std::abs(std::hypot(balance.contact_force[0], balance.contact_force[1]) / length_of_sum(pushes) - 1) <
        1e-12);
}
