// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/gauss_newton.h"
#include "control/misfit.h"
#include "drivers/fit_outcome.h"
#include "fixtures.h"
#include "io/fit_tables.h"
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
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

namespace {

/// Data e^{−t}, e^{−2t} … of a decay whose rate is sought by its logarithm, x = log θ.
std::optional<LeastSquares> decay(std::span<const double> x) {
  LeastSquares at;
  const double rate = std::exp(x[0]);
  for (int k = 1; k <= 5; ++k)
    at.residuals.push_back(1e3 * (std::exp(-rate * k) - std::exp(-1.0 * k)));
  for (int k = 1; k <= 5; ++k)
    at.jacobian.push_back(-1e3 * k * rate * std::exp(-rate * k));
  return at;
}

optimize::GaussNewtonResult search_decay(double start, const optimize::Box& box, double& longest) {
  longest = 0;
  double before = start;
  return optimize::gauss_newton(decay, {.x = {start}, .at = *decay(std::vector{start})}, box,
                                {.tolerance = 1e-8}, [&](const optimize::GaussNewtonIterate& now) {
                                  longest = std::max(longest, std::abs(now.x[0] - before));
                                  before = now.x[0];
                                  return true;
                                });
}

} // namespace

TEST_CASE("steps within their limit reach a minimum from which longer ones run away", "[optimize]") {
  // From a rate of e⁻⁴ the whole step leads to e⁹, where J is lower and all derivatives are zero.
  double longest = 0;
  const optimize::GaussNewtonResult lost = search_decay(-4, {{-infinity}, {infinity}}, longest);
  REQUIRE(longest > 5);
  REQUIRE(std::abs(lost.last.x[0]) > 5);
  const double start = GENERATE(-6.0, -4.0, -2.0, 0.5, 1.5);
  const optimize::GaussNewtonResult found = search_decay(start, {{-infinity}, {infinity}, {1}}, longest);
  CHECK(found.stop == optimize::Stop::gradient_tolerance);
  CHECK(std::abs(found.last.x[0]) < 1e-8);
  CHECK(longest <= 1);
}

TEST_CASE("at the floor of a logarithm the gradient decides whether a search ends there", "[optimize]") {
  // r = θ + b, ½ r² falls towards θ = 0 for b > 0, and away from it for b < 0.
  const double b = GENERATE(2.0, -2.0), floor = std::log(1.5e-8);
  const auto evaluate = [&](std::span<const double> x) -> std::optional<LeastSquares> {
    return LeastSquares{{std::exp(x[0]) + b}, {std::exp(x[0])}};
  };
  const optimize::GaussNewtonResult found = optimize::gauss_newton(
      evaluate, {.x = {floor}, .at = *evaluate(std::vector{floor})}, {{floor}, {infinity}, {1}},
      {.tolerance = 1e-8}, [](const optimize::GaussNewtonIterate&) { return true; });
  CHECK(found.stop == optimize::Stop::gradient_tolerance);
  if (b > 0)
    CHECK(found.last.x[0] == floor);
  else
    CHECK(std::abs(std::exp(found.last.x[0]) + b) < 1e-8);
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
  CHECK(known.unidentified.empty());
}

TEST_CASE("directions that nothing tells are said in words", "[optimize]") {
  using enum scene::ParameterScale;
  const std::vector<scene::Unknown> logs{named("young", logarithmic), named("density", logarithmic)};
  // Residuals that depend on the difference, the sum, or x_1 alone.
  for (const auto& [row, words] :
       {std::pair(std::vector{1.0, -1.0}, "The data determine only the ratio of young and density."),
        std::pair(std::vector{3.0, 3.0}, "The data determine only the product of young and density."),
        std::pair(std::vector{1.0, 0.0}, "The data do not determine density.")}) {
    const std::vector<double> H{row[0] * row[0], row[0] * row[1], row[0] * row[1], row[1] * row[1]};
    const optimize::Identified known = optimize::identified(H, 2);
    REQUIRE(known.unidentified.size() == 1);
    CHECK(drivers::unidentified(logs, known.unidentified.front()) == words);
    CHECK(std::isinf(known.deviations[1]));
  }
  const std::vector<scene::Unknown> mixed{named("height", linear), named("speed", linear)};
  CHECK(drivers::unidentified(mixed, {1, -0.5}) ==
        "The data do not separate height, speed: joint changes in the proportion height by +1, speed by "
        "-0.5 leave all simulated values unchanged.");
}

TEST_CASE("an unknown on a logarithmic scale ends where the curvature of J is rounding", "[control]") {
  const double root = std::sqrt(std::numeric_limits<double>::epsilon());
  const auto box = [](const scene::Scene& scene) {
    return control::Misfit(scene, io::read_data(MPI_COMM_WORLD, scene)).box();
  };
  const scene::Scene scene = test::parse(test::source("scenes/drop-test.toml"));
  const optimize::Box free = box(scene);
  REQUIRE(scene.unknowns.size() == 2);
  for (std::size_t j = 0; j < 2; ++j) {
    REQUIRE(scene.unknowns[j].logarithmic());
    CHECK(std::abs(free.lower[j] - std::log(root * scene.unknowns[j].start)) < 1e-12);
    CHECK(std::abs(free.upper[j] - std::log(scene.unknowns[j].start / root)) < 1e-12);
  }
  const scene::Scene bounded = test::parse(test::source("scenes/drop-test.toml"),
                                           {"unknown=[{of=\"young\", start=6e6, lower=1e6, upper=8e6}]"});
  const optimize::Box given = box(bounded);
  CHECK(std::abs(given.lower[0] - std::log(1e6)) < 1e-12);
  CHECK(std::abs(given.upper[0] - std::log(8e6)) < 1e-12);
}
