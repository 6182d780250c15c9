// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/foundations.h"
#include "body.h"
#include "scene/parameters.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>

using namespace signorini;
using Catch::Matchers::ContainsSubstring;
using test::Body, test::energy;

namespace {

const char* const all_round = "foundation=[{on=\"boundary\", stiffness={normal=3, tangential=5}, "
                              "damping={normal=7, tangential=11}}]";
const char* const rayleigh = "material.rayleigh={alpha=0.7, beta=0.02}";

} // namespace

TEST_CASE("foundations act along and across the normal of their surface", "[fem]") {
  const int degree = GENERATE(1, 2);
  CAPTURE(degree);
  const Body body("tests/data/block.toml", degree,
                  {"foundation=[{on=\"bottom\", stiffness={normal=3, tangential=5}, damping={normal=7}}]"});
  const petsc::Vector along = body.field({"0", "1"}), across = body.field({"1", "0"}),
                      linear = body.field({"x", "x"});
  CHECK(std::abs(energy(body.operators.foundation_A, along) - 3) < 1e-13);
  CHECK(std::abs(energy(body.operators.foundation_A, across) - 5) < 1e-13);
  CHECK(std::abs(energy(body.operators.foundation_A, linear) - (3 + 5) / 3.0) < 1e-13);
  CHECK(std::abs(energy(body.operators.foundation_B, along) - 7) < 1e-13);
  CHECK(std::abs(energy(body.operators.foundation_B, across)) < 1e-13);
  CHECK_FALSE(body.operators.drag);
  // A translation strains nothing: what A and B have on it, the foundation gives.
  CHECK(std::abs(energy(body.operators.A, across) - 5) < 1e-12);
  CHECK(std::abs(energy(*body.operators.B, along) - 7) < 1e-12);
}

TEST_CASE("foundations act on surfaces in space", "[fem]") {
  const int degree = GENERATE(1, 2);
  CAPTURE(degree);
  const Body body("tests/data/cube.toml", degree,
                  {"foundation=[{on=\"bottom\", stiffness={normal=3, tangential=5}}]"});
  CHECK(std::abs(energy(body.operators.foundation_A, body.field({"0", "0", "1"})) - 3) < 1e-12);
  CHECK(std::abs(energy(body.operators.foundation_A, body.field({"1", "0", "0"})) - 5) < 1e-12);
  CHECK(std::abs(energy(body.operators.foundation_A, body.field({"0", "1", "0"})) - 5) < 1e-12);
}

TEST_CASE("absorbing foundations have the impedances of the material at each facet", "[fem]") {
  const Body body("tests/data/two-materials.toml", 1, {"foundation=[{on=\"boundary\", absorbing=true}]"});
  // The boundary of [0, 2] x [0, 1]: the left square has half of the horizontal sides and the side x = 0.
  double along_x = 0, along_y = 0;
  for (const scene::Material& material : body.scene.materials) {
    const double E = material.young, nu = material.poisson, rho = material.density;
    const double pressure = rho * std::sqrt(E * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) / rho),
                 shear = rho * std::sqrt(E / (2 * (1 + nu)) / rho);
    along_x += pressure + 2 * shear;
    along_y += shear + 2 * pressure;
  }
  CHECK(std::abs(energy(body.operators.foundation_B, body.field({"1", "0"})) / along_x - 1) < 1e-13);
  CHECK(std::abs(energy(body.operators.foundation_B, body.field({"0", "1"})) / along_y - 1) < 1e-13);
  CHECK_FALSE(body.operators.foundation_A);
}

TEST_CASE("absorbing foundations change with the constants of a material that relaxes", "[fem]") {
  using Of = scene::Parameter;
  const char* const moduli = GENERATE(as<const char*>{}, "instantaneous", "long-term");
  const scene::Parameter of =
      GENERATE(Of::density, Of::young, Of::poisson, Of::prony_g, Of::prony_k, Of::prony_time, Of::beta);
  CAPTURE(moduli, scene::name(of));
  const Body body("tests/data/block.toml", 1,
                  {"foundation=[{on=\"boundary\", absorbing=true}]", std::string("material.moduli=") + moduli,
                   "material.prony=[{g=0.3, k=0.1, time=0.01}, {g=0.2, k=0.3, time=0.1}]", rayleigh});
  const auto number = [&](scene::Material& material) -> double& {
    return of == Of::density   ? material.density
           : of == Of::young   ? material.young
           : of == Of::poisson ? material.poisson
           : of == Of::beta    ? material.rayleigh->beta
                               : scene::number_of(material.prony[1], of);
  };
  const petsc::Vector x = test::smooth(body.space, 1);
  std::vector<scene::Material> materials = body.scene.materials;
  double& value = number(materials.front());
  const double own = value, h = 1e-5 * own;
  const auto at = [&](double there) {
    value = there;
    return energy(fem::assemble_dashpots(body.space, body.scene.foundations, materials), x);
  };
  const double difference = (at(own + h) - at(own - h)) / (2 * h), size = at(own) / own;
  const petsc::Matrix rate =
      fem::assemble_absorption_rate(body.space, body.scene.foundations, materials, 0, of);
  const bool fraction = of == Of::prony_g || of == Of::prony_k;
  const bool constant =
      of == Of::prony_time || of == Of::beta || (fraction && std::string_view(moduli) == "instantaneous");
  CHECK((Mat(rate) == nullptr) == constant);
  CHECK(std::abs((rate ? energy(rate, x) : 0) - difference) < 1e-8 * size);
  CHECK((std::abs(difference) < 1e-8 * size) == constant);
}

TEST_CASE("an absorbing foundation inside the body is refused", "[fem]") {
  CHECK_THROWS_WITH(
      Body("tests/data/two-materials.toml", 1, {"foundation=[{on=\"interface\", absorbing=true}]"}),
      ContainsSubstring("foundation[0].on: found \"interface\", which has facets inside the body"));
}

TEST_CASE("Rayleigh damping is alpha M + beta A", "[fem]") {
  const int degree = GENERATE(1, 2);
  CAPTURE(degree);
  const Body body("tests/data/block.toml", degree, {"material.viscosity={bulk=0, shear=0}", rayleigh});
  const petsc::Vector x = test::smooth(body.space, 1);
  const double expected = 0.7 * energy(body.operators.M, x) + 0.02 * energy(body.operators.A, x);
  CHECK(std::abs(energy(*body.operators.B, x) / expected - 1) < 1e-13);
  CHECK(std::abs(energy(body.operators.drag, x) / (0.7 * energy(body.operators.M, x)) - 1) < 1e-13);
}

TEST_CASE("the step operator has the terms of the surroundings", "[fem]") {
  const int degree = GENERATE(1, 2);
  CAPTURE(degree);
  const Body body("tests/data/block.toml", degree, {all_round, rayleigh});
  constexpr double tau = 0.3;
  const petsc::Vector x = test::smooth(body.space, 1);
  const petsc::Matrix D = fem::assemble_step_operator(body.space, body.scene.materials, tau);
  const double without = energy(D, x);
  body.operators.add_surroundings(D, tau);
  const double expected = energy(body.operators.M, x) + tau / 2 * energy(*body.operators.B, x) +
                          tau * tau / 4 * energy(body.operators.A, x);
  CHECK(std::abs(energy(D, x) / expected - 1) < 1e-13);
  CHECK(std::abs(without / expected - 1) > 1e-2);
}

TEST_CASE("energy and momentum laws hold with foundations, dashpots and mass damping", "[forward]") {
  const char* const scheme = GENERATE(as<const char*>{}, "contact.mass=consistent", "contact.mass=massless",
                                      "time.scheme=contact-stabilized");
  const char* const degree = GENERATE(as<const char*>{}, "mesh.degree=1", "mesh.degree=2");
  CAPTURE(scheme, degree);
  const test::Ready ready("tests/data/block.toml",
                          {scheme, degree, all_round, rayleigh, "initial.velocity=[\"0\", -4]"});
  const test::Laws found(test::Recorded(ready.problem, ready.problem.load()));
  CHECK(found.touched > 0);
  CHECK(found.energy < 1e-12);
  CHECK(found.momentum < 1e-12);
  CHECK(found.foundation > 1e-2);
  CHECK(found.dashpots > 1e-2);
  CHECK(found.drag > 1e-2);
}
