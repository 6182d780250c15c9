// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/relaxation.h"
#include "body.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>

using namespace signorini;
using test::Body, test::energy;

namespace {

const char* const two_branches = "material.prony=[{g=0.4, k=0.1, time=0.05}, {g=0.2, k=0, time=2}]";

/// Returns x · Σ_j weights_j A_j x.
double branch_energy(const Body& body, std::span<const double> weights, Vec x) {
  petsc::Series same;
  for (std::size_t j = 0; j < weights.size(); ++j)
    same.push_back(petsc::copy(x));
  const petsc::Vector product = petsc::zero_like(x), work = petsc::zero_like(x);
  body.operators.relaxation->add({.weights = weights, .vectors = same}, product, work);
  return petsc::dot(x, product);
}

} // namespace

TEST_CASE("long-term stiffness and branches add up to the instantaneous stiffness", "[fem]") {
  const int degree = GENERATE(1, 2);
  const char* const series =
      GENERATE(as<const char*>{}, two_branches, "material.prony=[{g=0.3, k=0.3, time=1}]",
               "material.prony=[{g=0, k=0.3, time=1}]");
  CAPTURE(degree, series);
  const Body elastic("tests/data/block.toml", degree, {}), body("tests/data/block.toml", degree, {series});
  REQUIRE(body.operators.relaxation);
  CHECK_FALSE(elastic.operators.relaxation);
  const petsc::Vector x = test::smooth(body.space, 1);
  const std::vector<double> ones(body.operators.relaxation->branches().size(), 1.0);
  const double branches = branch_energy(body, ones, x), whole = energy(elastic.operators.A, x);
  CHECK(std::abs(energy(body.operators.A, x) + branches - whole) < 1e-12 * whole);
  CHECK(branches > 0.01 * whole);
  CHECK(std::abs(energy(body.operators.M, x) - energy(elastic.operators.M, x)) == 0);
}

TEST_CASE("branches act on their material alone", "[fem]") {
  Body body("tests/data/two-materials.toml", 1, {"material.0.prony=[{g=0.4, k=0.2, time=0.05}]"});
  const std::vector<double> ones(1, 1.0);
  const petsc::Vector x = test::smooth(body.space, 1);
  const Body elastic("tests/data/two-materials.toml", 1, {});
  const double whole = energy(elastic.operators.A, x);
  CHECK(std::abs(energy(body.operators.A, x) + branch_energy(body, ones, x) - whole) < 1e-12 * whole);
  // Beyond the first material, which fills the left square, a displacement does not strain the branches.
  petsc::Vector right = body.space.vector();
  body.space.interpolate({{"x > 1 ? (x - 1)^2 : 0", "0"}, "test", false}, 0, right);
  CHECK(std::abs(branch_energy(body, ones, right)) < 1e-12 * energy(body.operators.A, right));
}

TEST_CASE("the step operator has the branches with their gains", "[fem]") {
  const int degree = GENERATE(1, 2);
  const std::string moduli = GENERATE("instantaneous", "long-term");
  CAPTURE(degree, moduli);
  const Body body("tests/data/block.toml", degree, {two_branches, "material.moduli=" + moduli});
  constexpr double tau = 0.3;
  std::vector<double> gains;
  for (const fem::Relaxation::Branch& branch : body.operators.relaxation->branches())
    gains.push_back(scene::branch_step(tau, branch.time).gain);
  const petsc::Vector x = test::smooth(body.space, 1);
  const double expected = energy(body.operators.M, x) + tau / 2 * energy(*body.operators.B, x) +
                          tau * tau / 4 * (energy(body.operators.A, x) + branch_energy(body, gains, x));
  const petsc::Matrix D = fem::assemble_step_operator(body.space, body.scene.materials, tau);
  CHECK(std::abs(energy(D, x) / expected - 1) < 1e-12);
}

TEST_CASE("energy and momentum laws hold in materials that relax", "[forward]") {
  const char* const scheme = GENERATE(as<const char*>{}, "contact.mass=consistent", "contact.mass=massless",
                                      "time.scheme=contact-stabilized");
  const char* const degree = GENERATE(as<const char*>{}, "mesh.degree=1", "mesh.degree=2");
  CAPTURE(scheme, degree);
  const test::Ready ready("tests/data/block.toml",
                          {scheme, degree, two_branches, "initial.velocity=[\"0\", -4]"});
  const test::Laws found(test::Recorded(ready.problem, ready.problem.load()));
  CHECK(found.touched > 0);
  CHECK(found.energy < 1e-12);
  CHECK(found.momentum < 1e-12);
  CHECK(found.branches > 1e-2);
  CHECK(found.relaxed > 1e-2);
  CHECK(found.least_relaxed >= -1e-14); // rounding where nothing strains
}

TEST_CASE("automatic steps are at most twice the time of a branch that the shortest resolve", "[forward]") {
  scene::Scene scene;
  scene.time.end = 0.6;
  constexpr double wave_time = 1e-3;
  scene.materials.resize(1);
  const double longest = step::step_lengths(scene, wave_time)->longest_step(),
               shortest = step::step_lengths(scene, wave_time)->shortest_step();
  CHECK(longest == scene.time.end / scene::Time::usual_longest);
  scene.materials[0].prony = {{.g = 0.1, .time = 1.0}, {.g = 0.1, .time = shortest / 4}};
  CHECK(step::step_lengths(scene, wave_time)->longest_step() == longest); // one slow, one too fast to resolve
  scene.materials[0].prony.push_back({.k = 0.1, .time = 0.01});
  const step::StepLengths limited = *step::step_lengths(scene, wave_time);
  CHECK(limited.longest_step() <= 2 * 0.01);
  CHECK(limited.longest_step() > 0.9 * 2 * 0.01);
  CHECK(limited.shortest_step() <= 2 * shortest);
}
