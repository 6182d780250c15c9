// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/gauss_newton.h"
#include "app/fit/outcome.h"
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <limits>

using namespace signorini;
using optimize::LeastSquares;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Rosenbrock's valley: r = (10 (x_2 − x_1²), 1 − x_1), solved by (1, 1).
std::optional<LeastSquares> rosenbrock(std::span<const double> x) {
  return LeastSquares{{10 * (x[1] - x[0] * x[0]), 1 - x[0]}, {-20 * x[0], -1, 10, 0}};
}

optimize::GaussNewtonResult search(std::vector<double> x, const optimize::Box& box, int most = 100) {
  const LeastSquares at = *rosenbrock(x);
  return optimize::gauss_newton(rosenbrock, {.x = std::move(x), .at = at}, box,
                                {.max_iterations = most, .tolerance = 1e-10},
                                [](const optimize::GaussNewtonIterate&) { return true; });
}

const optimize::Box unbounded{{-infinity, -infinity}, {infinity, infinity}};

scene::Unknown named(const char* name, scene::ParameterScale scale) {
  scene::Unknown unknown;
  unknown.name = name;
  unknown.scale = scale;
  return unknown;
}

} // namespace

TEST_CASE("Gauss-Newton steps find a valley's end, and go on where they stopped", "[optimize]") {
  const optimize::GaussNewtonResult whole = search({-1.2, 1}, unbounded);
  CHECK(whole.stop == optimize::Stop::gradient_tolerance);
  CHECK(std::abs(whole.last.x[0] - 1) < 1e-9);
  CHECK(std::abs(whole.last.x[1] - 1) < 1e-9);
  const optimize::GaussNewtonResult half = search({-1.2, 1}, unbounded, 3);
  REQUIRE(half.stop == optimize::Stop::iteration_limit);
  REQUIRE(half.last.number == 3);
  const optimize::GaussNewtonResult rest =
      optimize::gauss_newton(rosenbrock, half.last, unbounded, {.max_iterations = 100, .tolerance = 1e-10},
                             [](const optimize::GaussNewtonIterate&) { return true; });
  CHECK(std::abs(rest.last.x[1] - 1) < 1e-9);
}

TEST_CASE("bounds hold at every iterate, and the minimiser on them is found", "[optimize]") {
  // On x_1 <= 1/2 the least of 50 (x_2 − x_1²)² + ½ (1 − x_1)² is at (1/2, 1/4).
  const optimize::Box box{{-infinity, -infinity}, {0.5, infinity}};
  const optimize::GaussNewtonResult found = search({-1.2, 1}, box);
  CHECK(found.stop == optimize::Stop::gradient_tolerance);
  CHECK(found.last.x[0] == 0.5);
  CHECK(std::abs(found.last.x[1] - 0.25) < 1e-9);
}

TEST_CASE("a trial that fails is a step too long", "[optimize]") {
  int failures = 0;
  const auto evaluate = [&](std::span<const double> x) -> std::optional<LeastSquares> {
    if (x[0] > 1.5 || x[0] < -1.3) {
      ++failures;
      return std::nullopt;
    }
    return LeastSquares{{std::exp(x[0]) - std::exp(1)}, {std::exp(x[0])}};
  };
  const optimize::GaussNewtonResult found = optimize::gauss_newton(
      evaluate, {.x = {-1}, .at = *evaluate(std::vector{-1.0})}, {{-infinity}, {infinity}},
      {.tolerance = 1e-10}, [](const optimize::GaussNewtonIterate&) { return true; });
  CHECK(failures > 0);
  CHECK(std::abs(found.last.x[0] - 1) < 1e-9);
}

TEST_CASE("what data tell of two unknowns is the inverse of their normal matrix", "[optimize]") {
  const std::vector<double> H{4, 2, 2, 5}; // inverse: (5, −2; −2, 4) / 16
  const optimize::Identified known = optimize::identified(H, 2);
  CHECK(std::abs(known.deviations[0] - std::sqrt(5.0 / 16)) < 1e-14);
  CHECK(std::abs(known.deviations[1] - std::sqrt(4.0 / 16)) < 1e-14);
  CHECK(std::abs(known.correlations[1] + 2 / std::sqrt(20.0)) < 1e-14);
  CHECK(known.untold.empty());
}

TEST_CASE("directions that nothing tells are said in words", "[optimize]") {
  using enum scene::ParameterScale;
  const std::vector<scene::Unknown> logs{named("young", logarithmic), named("density", logarithmic)};
  // Residuals that depend on the difference, the sum, or x_1 alone.
  for (const auto& [row, words] :
       {std::pair(std::vector{1.0, -1.0}, "The data tell young and density only as their ratio."),
        std::pair(std::vector{3.0, 3.0}, "The data tell young and density only as their product."),
        std::pair(std::vector{1.0, 0.0}, "The data do not tell density.")}) {
    const std::vector<double> H{row[0] * row[0], row[0] * row[1], row[0] * row[1], row[1] * row[1]};
    const optimize::Identified known = optimize::identified(H, 2);
    REQUIRE(known.untold.size() == 1);
    CHECK(untold(logs, known.untold.front()) == words);
    CHECK(std::isinf(known.deviations[1]));
  }
  const std::vector<scene::Unknown> mixed{named("height", linear), named("speed", linear)};
  CHECK(untold(mixed, {1, -0.5}) == "The data do not tell height, speed apart: changes in the proportion of "
                                    "height by +1, speed by -0.5 leave "
                                    "all values as they are.");
}
