// SPDX-License-Identifier: GPL-3.0-or-later
#include "unit/fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <fmt/format.h>

using namespace signorini;
using petsc::check;

namespace {

constexpr const char *plane = "tests/data/manufactured.toml", *space = "tests/data/manufactured-space.toml";

constexpr double end = 0.5; // of all these scenes, s

/// L2 error of the displacement at the end, against the nodal interpolant of the exact one.
double error(const char* scene, const scene::Components& solution, int degree, double size, int steps,
             std::vector<std::string> overrides = {}) {
  overrides.insert(overrides.end(),
                   {fmt::format("mesh.degree={}", degree), fmt::format("mesh.size={:.17g}", size),
                    fmt::format("time.step={:.17g}", end / steps)});
  const test::Ready ready(scene, overrides);
  const test::Recorded trajectory(ready.problem);
  REQUIRE(trajectory.steps == steps);
  petsc::Vector exact = ready.problem.space.vector(), product = ready.problem.space.vector();
  ready.problem.space.interpolate(scene::Field(solution, "test", false), 0, exact);
  check(VecAXPY(exact, -1, trajectory.y.back()));
  check(MatMult(fem::assemble_operators(ready.problem.space, ready.scene.materials, true).W.value(), exact,
                product));
  return std::sqrt(petsc::dot(exact, product));
}

/// The same of M1 in the plane or in space.
double error(const char* scene, int degree, double size, int steps) {
  const bool solid = std::string_view(scene) == space;
  const std::string component =
      fmt::format("{:.17g}*sin(pi*x)*sin(pi*y){}", std::sin(6 * end), solid ? "*sin(pi*z)" : "");
  return error(scene, scene::Components(solid ? 3 : 2, component), degree, size, steps);
}

petsc::Vector end_state(int steps) {
  const test::Ready ready(plane, {fmt::format("time.step={:.17g}", end / steps)});
  const test::Recorded trajectory(ready.problem);
  return petsc::copy(trajectory.y.back());
}

double order(double coarse, double fine, double ratio) { return std::log(coarse / fine) / std::log(ratio); }

} // namespace

TEST_CASE("M1: order degree + 1 in space", "[manufactured]") {
  for (int degree : {1, 2}) {
    // Steps in proportion to h^((r+1)/2), so that the time error, of order 2, falls as fast as the one in
    // space.
    std::vector<double> errors;
    std::vector<int> steps = degree == 1 ? std::vector{20, 40, 80, 160} : std::vector{25, 71, 200, 566};
    for (int level = 0; level < 4; ++level)
      errors.push_back(error(plane, degree, 0.25 / (1 << level), steps[static_cast<std::size_t>(level)]));
    for (std::size_t i = 1; i < errors.size(); ++i)
      fmt::print("M1 degree {}: h = {:.5f}, {} steps, L2 error {:.3e}, order {:.2f}\n", degree,
                 0.25 / (1 << i), steps[i], errors[i], order(errors[i - 1], errors[i], 2));
    const double observed = order(errors[1], errors[3], 4);
    CHECK(std::abs(observed - (degree + 1)) < 0.2);
  }
}

TEST_CASE("M1 in space: order degree + 1 at least", "[manufactured]") {
  // Two sizes beyond which a finer mesh would take long; against the interpolant degree 2 is still gaining
  // faster there.
  struct Level {
    double size;
    int steps;
  };
  for (const auto& [degree, coarse, fine] :
       {std::tuple{1, Level{0.125, 40}, Level{0.0625, 80}}, {2, {0.25, 57}, {0.125, 160}}}) {
    const double first = error(space, degree, coarse.size, coarse.steps),
                 second = error(space, degree, fine.size, fine.steps);
    const double observed = order(first, second, coarse.size / fine.size);
    fmt::print("M1 in space, degree {}: h = {:.4f}, {} steps, L2 error {:.3e}, order {:.2f}\n", degree,
               fine.size, fine.steps, second, observed);
    CHECK(observed > degree + 1 - 0.2);
  }
}

TEST_CASE("M1: order 2 in time", "[manufactured]") {
  // Against a run with many more steps on the same mesh.
  const petsc::Vector reference = end_state(2560);
  double errors[3];
  for (int i = 0; i < 3; ++i)
    errors[i] = test::difference(end_state(20 << i), reference);
  for (int i = 1; i < 3; ++i) {
    fmt::print("M1 time: {} steps, error {:.3e}, order {:.2f}\n", 20 << i, errors[i],
               order(errors[i - 1], errors[i], 2));
    CHECK(std::abs(order(errors[i - 1], errors[i], 2) - 2) < 0.1);
  }
}

TEST_CASE("a bar of two materials: order degree + 1 at least", "[manufactured]") {
  const char* bar = "tests/data/bar.toml";
  const double k = std::atan(std::sqrt(2.0 / 3));
  const std::string mode = "(x < 1 ? sin(atan(sqrt(2/3))*x) : sqrt(10)*cos(2*atan(sqrt(2/3))*(2-x)))",
                    component = fmt::format("{:.17g}*{}", std::cos(2 * k * end), mode);
  for (int degree : {1, 2}) {
    std::vector<double> errors;
    const std::vector<int> steps = degree == 1 ? std::vector{20, 40, 80, 160} : std::vector{25, 71, 200, 566};
    for (int level = 0; level < 4; ++level)
      errors.push_back(
          error(bar, {component, "0"}, degree, 0.25 / (1 << level), steps[static_cast<std::size_t>(level)]));
    for (std::size_t i = 1; i < errors.size(); ++i)
      fmt::print("bar of two materials, degree {}: h = {:.4f}, {} steps, L2 error {:.3e}, order {:.2f}\n",
                 degree, 0.25 / (1 << i), steps[i], errors[i], order(errors[i - 1], errors[i], 2));
    CHECK(order(errors[1], errors[3], 4) > degree + 1 - 0.2);
  }
  const auto in_space = [&](double size, int steps) {
    return error(bar, {component, "0", "0"}, 1, size, steps,
                 {"mesh.file=parts-space.geo", "initial.displacement=[\"" + mode + "\", \"0\", \"0\"]"});
  };
  const double coarse = in_space(0.25, 20), fine = in_space(0.125, 40);
  fmt::print("bar of two materials in space: h = 0.125, L2 error {:.3e}, order {:.2f}\n", fine,
             order(coarse, fine, 2));
  CHECK(order(coarse, fine, 2) > 2 - 0.2);
}
