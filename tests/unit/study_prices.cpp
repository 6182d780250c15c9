// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/refinement_loop.h"
#include "accuracy/rung_costs.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <cmath>

using namespace signorini::accuracy;
using Catch::Matchers::WithinRel;

namespace {

/// What a set-up of a + b n^p and steps of c + d n^p take.
CostModel::Timed timed(double n, int dim) {
  const double power = std::pow(n, step_power(dim));
  return {n, 0.02 + 3e-7 * power, 2e-5 + 5e-9 * power};
}

} // namespace

TEST_CASE("the cost of a constant and a power of the unknowns is found from two meshes", "[study]") {
  const int dim = GENERATE(2, 3);
  CAPTURE(dim);
  const CostModel cost({timed(100, dim), timed(4000, dim)}, dim);
  for (const double n : {50.0, 1000.0, 1e5})
    for (const int steps : {1, 40, 10'000}) {
      const CostModel::Timed at = timed(n, dim);
      CHECK_THAT(cost.seconds(n, steps), WithinRel(at.setup + steps * at.step, 1e-10));
    }
}

TEST_CASE("of one mesh, or of times that make no sense, more unknowns never cost less", "[study]") {
  const CostModel one({timed(4000, 2)}, 2);
  const CostModel::Timed at = timed(4000, 2);
  CHECK_THAT(one.seconds(4000, 10), WithinRel(at.setup + 10 * at.step, 1e-12));
  CHECK_THAT(one.seconds(8000, 10) / one.seconds(4000, 10), WithinRel(std::pow(2, 1.2), 1e-12));
  // Grows faster than the power, and falls.
  const CostModel steep({{100, 1e-3, 1e-6}, {1000, 1, 1e-2}}, 2), falls({{100, 2, 1e-2}, {1000, 1, 1e-3}}, 2);
  CHECK_THAT(steep.seconds(1000, 10), WithinRel(1.1, 1e-12));
  CHECK_THAT(falls.seconds(1000, 10), WithinRel(1.01, 1e-12));
  for (const CostModel* cost : {&steep, &falls})
    for (double n = 10; n < 1e6; n *= 2)
      CHECK(cost->seconds(2 * n, 10) >= cost->seconds(n, 10));
}

TEST_CASE("prices are of the rung's own degree, and are corrected by what rungs have taken", "[study]") {
  const CostModel cost({timed(100, 2), timed(6400, 2)}, 2), dear({timed(6400, 2)}, 2);
  // Three quarters of the size's power between the meshes known, as of a body whose edges limit the coarse
  // one.
  RungCosts prices({{1, 2, {{4, 100}, {0.5, 100 * std::pow(8, 1.5)}}, cost}, {2, 2, {{1, 6400}}, dear}}, 3);
  CHECK_THAT(prices.unknowns({2, 10, 1, {}}), WithinRel(100 * std::pow(2, 1.5), 1e-12));
  CHECK_THAT(prices.unknowns({0.25, 10, 1, {}}), WithinRel(400 * std::pow(8, 1.5), 1e-12));
  CHECK_THAT(prices.unknowns({8, 10, 1, {}}), WithinRel(25, 1e-12));
  CHECK_THAT(prices.unknowns({0.5, 10, 2, {}}), WithinRel(4 * 6400, 1e-12));
  const Rung small{4, 10, 1, {}}, large{0.5, 1000, 1, {}}, quadratic{1, 10, 2, {}};
  CHECK_THAT(prices.seconds(small), WithinRel(cost.seconds(100, 10), 1e-12));
  CHECK_THAT(prices.seconds(quadratic), WithinRel(dear.seconds(6400, 10), 1e-12));
  // Steps that are chosen: 3 / √tolerance.
  CHECK_THAT(prices.seconds({.size = 4, .tolerance = 0.01}), WithinRel(cost.seconds(100, 30), 1e-12));
  const double before = prices.seconds(large);
  prices.learn(small, 3 * prices.seconds(small));
  CHECK_THAT(prices.seconds(large), WithinRel(3 * before, 1e-12));
  // Dear rungs count for more.
  prices.learn(large, before);
  CHECK_THAT(
      prices.seconds(large),
      WithinRel(before * (3 * cost.seconds(100, 10) + before) / (cost.seconds(100, 10) + before), 1e-12));
}

TEST_CASE("size and step for a target are the cheapest that meet it", "[study]") {
  const int dim = GENERATE(2, 3);
  const SizeAndStep error{0.3, 0.1}, orders{1.5, 2};
  constexpr double target = 0.02;
  const auto left = [&](double size, double step) {
    return error.size * std::pow(size, orders.size) + error.step * std::pow(step, orders.step);
  };
  const auto cost = [&](double size, double step) { return std::pow(size, -dim * step_power(dim)) / step; };
  const SizeAndStep found = cheapest_factors(error, orders, target, dim, 1e-6, 1);
  CHECK(std::abs(left(found.size, found.step) / target - 1) < 1e-12);
  for (const double other : {0.9, 0.99, 1.01, 1.1}) { // another size, and the step that then meets the target
    CAPTURE(other);
    const double size = other * found.size,
                 step = std::pow((target - error.size * std::pow(size, orders.size)) / error.step,
                                 1 / orders.step);
    CHECK(cost(size, step) > cost(found.size, found.step));
  }
  // A part that is small already leaves its share to the other, unless it may become coarser.
  const SizeAndStep small = cheapest_factors({0.3, 1e-4}, orders, target, dim, 1e-6, 1);
  CHECK(small.step == 1);
  CHECK(std::abs(0.3 * std::pow(small.size, orders.size) + 1e-4 - target) < 1e-12);
  CHECK(cheapest_factors({0.3, 1e-4}, orders, target, dim, 1e-6, 2).step == 2);
  CHECK(cheapest_factors(error, orders, 1e-9, dim, 0.5, 1).size == 0.5);
  CHECK(cheapest_factors({0, 0.1}, orders, target, dim, 0.5, 1).size == 1);
  CHECK(std::abs(observed_order(0.4, 0.1, 0.5, 1) - 2) < 1e-12);
  CHECK(observed_order(0.4, 0.39, 0.5, 1) == 0.5);
  CHECK(observed_order(0.4, 0.01, 0.5, 1) == 2.5);
  CHECK(observed_order(0.4, 0.39, 0.95, 1.3) == 1.3); // too little of a change
  CHECK(observed_order(0, 0.39, 0.5, 1.3) == 1.3);
}
