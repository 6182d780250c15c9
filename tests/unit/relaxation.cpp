// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/relaxation.h"
#include "fixtures.h"
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>

using namespace signorini;
using petsc::check;

namespace {

const char* const two_branches = "material.prony=[{g=0.4, k=0.1, time=0.05}, {g=0.2, k=0, time=2}]";

/// A body of a scene of tests/data, whose boundary has no foundations.
struct Body {
  scene::Scene scene;
  std::shared_ptr<const problem::SpaceDiscretisation> shared;
  fem::Space space;
  fem::Operators operators;
  Body(const char* file, int degree, const std::vector<std::string>& overrides)
      : scene(test::parse(test::source(file), overrides)), shared(test::discretised(scene)),
        space(shared->mesh, degree), operators(fem::assemble_operators(space, scene.materials, true)) {}
};

double energy(Mat matrix, Vec x) {
  const petsc::Vector product = petsc::zero_like(x);
  check(MatMult(matrix, x, product));
  return petsc::dot(x, product);
}

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
  const test::Recorded motion(ready.problem, ready.problem.load());
  double most = 0, energy_residual = 0, momentum_residual = 0, stored = 0, lost = 0;
  int touched = 0;
  for (const diagnostics::StepBalance& step : motion.balance)
    most = std::max(most, step.energy());
  for (std::size_t k = 1; k < motion.balance.size(); ++k) {
    const diagnostics::StepBalance& step = motion.balance[k];
    energy_residual = std::max(energy_residual, std::abs(step.energy_residual) / most);
    momentum_residual =
        std::max(momentum_residual, diagnostics::length(step.momentum_residual) / step.momentum_scale);
    stored = std::max(stored, step.relaxation_energy / most);
    CHECK(step.relaxation_dissipation >= -1e-14 * most); // rounding where nothing strains
    lost += step.relaxation_dissipation / most;
    touched += motion.contact[k].count(contact::Status::strong) > 0;
  }
  CHECK(touched > 0);
  CHECK(energy_residual < 1e-12);
  CHECK(momentum_residual < 1e-12);
  CHECK(stored > 1e-2);
  CHECK(lost > 1e-2);
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
