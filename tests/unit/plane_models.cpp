// SPDX-License-Identifier: GPL-3.0-or-later
#include "body.h"
#include "contact/placement.h"
#include "fem/cell_fields.h"
#include "fem/deformation.h"
#include "fem/rigid_motions.h"
#include "fem/wave_time.h"
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <numbers>

using namespace signorini;
using Catch::Approx;
using Catch::Matchers::ContainsSubstring;
using std::numbers::pi;
using test::Body, test::energy;

namespace {

const char* const block = "tests/data/block.toml"; // the square [0, 1]²; E = 50, ν = 0.3, ρ = 1
const char* const axisymmetric = "mesh.model=axisymmetric";
const char* const plane_stress = "mesh.model=plane-stress";
const char* const flat = "contact.obstacle.normal=[0, 1]";
/// The viscosity that plane stress admits: K/G = 2 (1 + ν)/(3 (1 − 2ν)) of ν = 0.3.
const char* const proportional = "material.viscosity={bulk=0.10833333333333333, shear=0.05}";
constexpr double E = 50, nu = 0.3, lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu));

} // namespace

TEST_CASE("a square section is a cylinder in axial symmetry", "[fem]") {
  const int degree = GENERATE(1, 2);
  CAPTURE(degree);
  const Body body(block, degree, {axisymmetric, flat, "foundation=[{on=\"bottom\", stiffness={normal=3}}]"});
  const petsc::Vector along = body.field({"0", "1"}), stretch = body.field({"2*x", "-0.7*y"});
  CHECK(energy(body.operators.M, along) == Approx(pi).epsilon(1e-13));
  CHECK(energy(body.operators.foundation_A, along) == Approx(3 * pi).epsilon(1e-13));
  // ε = diag(2, −0.7, 2) in the volume π.
  const double trace = 2 - 0.7 + 2, squares = 4 + 0.49 + 4;
  const double springs = energy(body.operators.foundation_A, stretch);
  CHECK(energy(body.operators.A, stretch) - springs ==
        Approx(pi * (lambda * trace * trace + 2 * mu * squares)).epsilon(1e-13));
  CHECK(energy(*body.operators.B, stretch) ==
        Approx(pi * ((0.05 - 2 * 0.05 / 3) * trace * trace + 2 * 0.05 * squares)).epsilon(1e-13));
}

TEST_CASE("nodes on the axis do not move radially", "[fem]") {
  const int degree = GENERATE(1, 2);
  CAPTURE(degree);
  const Body body(block, degree, {axisymmetric, flat});
  const fem::DirichletDofs clamped(body.space, {});
  long on_axis = 0;
  for (int node = 0; node < body.space.owned_nodes(); ++node) {
    const bool axis = body.space.points()[3 * static_cast<std::size_t>(node)] == 0;
    on_axis += axis;
    CHECK(clamped.contains(node, 0) == axis);
    CHECK_FALSE(clamped.contains(node, 1));
  }
  CHECK(test::total(on_axis) == 4 * degree + 1);
  const fem::RigidMotions motions(body.space, clamped, body.operators.M);
  REQUIRE(motions.count() == 1);
  const petsc::Vector along = body.field({"0", "1"});
  CHECK(std::abs(motions.coefficients(along)[0]) == Approx(std::sqrt(pi)).epsilon(1e-13));
  CHECK(test::largest(motions.basis()[0]) == Approx(1 / std::sqrt(pi)).epsilon(1e-12));
}

TEST_CASE("strain and stress of a body of revolution have a hoop component", "[fem]") {
  const int degree = GENERATE(1, 2);
  CAPTURE(degree);
  const Body body(block, degree, {axisymmetric, flat});
  fem::CellFields fields(body.space, fem::parts(body.space.mesh(), body.scene.materials));
  const petsc::Vector y = body.field({"0.02*x", "0"});
  fields.set(y, body.space.vector());
  const std::span<const double> stress = fields(fem::CellField::stress);
  for (std::size_t cell = 0; 9 * cell < stress.size(); ++cell) {
    CHECK(stress[9 * cell] == Approx(0.04 * lambda + 0.04 * mu).epsilon(1e-12));
    CHECK(stress[9 * cell + 8] == Approx(0.04 * lambda + 0.04 * mu).epsilon(1e-12));
    CHECK(stress[9 * cell + 4] == Approx(0.04 * lambda).epsilon(1e-12));
  }
  // Every cell passes through the axis; only the section of the cells is turned inside out once.
  CHECK(fem::deformation(body.space, body.field({"-1.2*x", "0"})).inverted == body.space.mesh().cells());
  CHECK(fem::deformation(body.space, y).inverted == 0);
  CHECK(fem::deformation(body.space, body.field({"-0.2*x", "0.1*y"})).strain.value ==
        Approx(0.2).epsilon(1e-7));
}

TEST_CASE("plane stress has no stress across the plate", "[fem]") {
  const int degree = GENERATE(1, 2);
  CAPTURE(degree);
  const char* const series = "material.prony=[{g=0.3, k=0.3, time=0.1}]";
  const Body body(block, degree, {plane_stress, proportional, series});
  // Uniaxial stress, in which only E acts.
  const petsc::Vector pull = body.field({"0.01*x", "-0.003*y"});
  CHECK(energy(body.operators.A, pull) == Approx(0.7 * E * 1e-4).epsilon(1e-12));
  const std::vector<double> one(1, 1.0);
  petsc::Series q;
  q.push_back(petsc::copy(pull));
  const petsc::Vector product = body.space.vector(), work = body.space.vector();
  body.operators.relaxation->add({.weights = one, .vectors = q}, product, work);
  CHECK(petsc::dot(pull, product) == Approx(0.3 * E * 1e-4).epsilon(1e-12));
  const double young_of_viscosity = 9 * 0.05 * 0.10833333333333333 / (3 * 0.10833333333333333 + 0.05);
  CHECK(energy(*body.operators.B, pull) == Approx(young_of_viscosity * 1e-4).epsilon(1e-12));
  fem::CellFields fields(body.space, fem::parts(body.space.mesh(), body.scene.materials));
  fields.set(pull, pull, q);
  const std::span<const double> stress = fields(fem::CellField::stress);
  for (std::size_t cell = 0; 9 * cell < stress.size(); ++cell) {
    CHECK(stress[9 * cell] == Approx(0.01 * (E + young_of_viscosity)).epsilon(1e-12));
    for (const std::size_t zero : {1, 2, 4, 5, 8})
      CHECK(std::abs(stress[9 * cell + zero]) < 1e-13 * E);
  }
  CHECK(fem::wave_speeds(body.scene.materials[0], scene::PlaneModel::plane_stress)[0] ==
        Approx(std::sqrt(E / (1 - nu * nu))).epsilon(1e-14));
}

TEST_CASE("matrices of plane models change with the constants of the material", "[fem]") {
  const char* const model = GENERATE(as<const char*>{}, axisymmetric, plane_stress);
  const int degree = GENERATE(1, 2);
  const fem::Form form = GENERATE(fem::Form::a_young, fem::Form::a_poisson, fem::Form::m_rho);
  CAPTURE(model, degree, static_cast<int>(form));
  const Body body(block, degree, {model, flat, proportional});
  const petsc::Vector x = test::smooth(body.space, 1);
  std::vector<scene::Material> materials = body.scene.materials;
  double& value = form == fem::Form::a_young     ? materials[0].young
                  : form == fem::Form::a_poisson ? materials[0].poisson
                                                 : materials[0].density;
  const double own = value, h = 1e-5 * own;
  const auto at = [&](double there) {
    value = there;
    const fem::Operators operators = fem::assemble_operators(body.space, materials, false);
    return energy(form == fem::Form::m_rho ? operators.M : operators.A, x);
  };
  const double difference = (at(own + h) - at(own - h)) / (2 * h);
  value = own;
  CHECK(energy(fem::assemble_rate(body.space, materials, 0, form), x) == Approx(difference).epsilon(1e-8));
}

TEST_CASE("the step operator of plane models is m + tau/2 b + tau^2/4 a", "[fem]") {
  const char* const model = GENERATE(as<const char*>{}, axisymmetric, plane_stress);
  const int degree = GENERATE(1, 2);
  CAPTURE(model, degree);
  const Body body(block, degree, {model, flat, proportional});
  constexpr double tau = 0.3;
  const petsc::Vector x = test::smooth(body.space, 1);
  const double expected = energy(body.operators.M, x) + tau / 2 * energy(*body.operators.B, x) +
                          tau * tau / 4 * energy(body.operators.A, x);
  CHECK(energy(fem::assemble_step_operator(body.space, body.scene.materials, tau), x) ==
        Approx(expected).epsilon(1e-13));
}

TEST_CASE("energy and momentum laws hold in plane models", "[forward]") {
  const char* const model = GENERATE(as<const char*>{}, axisymmetric, plane_stress);
  const char* const scheme = GENERATE(as<const char*>{}, "contact.mass=consistent", "contact.mass=massless",
                                      "time.scheme=contact-stabilized");
  const char* const degree = GENERATE(as<const char*>{}, "mesh.degree=1", "mesh.degree=2");
  CAPTURE(model, scheme, degree);
  const test::Ready ready(
      block, {model, flat, scheme, degree, proportional, "material.prony=[{g=0.3, k=0.3, time=0.05}]",
              "material.rayleigh={alpha=0.7, beta=0.02}", "initial.velocity=[\"0\", -4]",
              "foundation=[{on=\"boundary\", stiffness={normal=3, tangential=5}, damping={normal=7}}]"});
  const test::Laws found(test::Recorded(ready.problem, ready.problem.load()));
  CHECK(found.touched > 0);
  CHECK(found.energy < 1e-12);
  CHECK(found.momentum < 1e-12);
  for (const double share : {found.foundation, found.dashpots, found.drag, found.branches, found.relaxed})
    CHECK(share > 1e-3);
}

TEST_CASE("in degree 2 the axis has no candidate", "[contact]") {
  const char* const degree = GENERATE(as<const char*>{}, "mesh.degree=1", "mesh.degree=2");
  const test::Ready ready(block, {axisymmetric, flat, degree});
  const contact::ContactPairs& pairs = *ready.problem.stepper.pairs();
  const bool linear = std::string_view(degree) == "mesh.degree=1";
  CHECK(pairs.count() == (linear ? 5 : 8));
  CHECK((pairs.points()[0] == 0) == linear);
}

TEST_CASE("in degree 2 a node on the axis inside an obstacle is noticed", "[contact]") {
  const test::Ready ready(block, {axisymmetric, flat, "mesh.degree=2"});
  const contact::ContactPairs& pairs = *ready.problem.stepper.pairs();
  REQUIRE(pairs.skips_axis());
  const petsc::Vector down = Body(block, 2, {axisymmetric, flat}).field({"0", "-0.15"});
  const auto deepest = pairs.deepest_on_axis(down, 0); // the plane is 0.1 m below
  CHECK(deepest.depth == Approx(0.05).epsilon(1e-12));
  CHECK(deepest.x == std::array<double, 3>{0, 0, 0});
  CHECK_THROWS_WITH(contact::place_outside(pairs, down),
                    ContainsSubstring("on the axis starts 0.05 m inside"));
  const test::Ready linear(block, {axisymmetric, flat});
  CHECK_FALSE(linear.problem.stepper.pairs()->skips_axis());
}

TEST_CASE("scenes without axial symmetry are refused", "[fem]") {
  CHECK_THROWS_WITH(Body(block, 1, {axisymmetric, flat, "foundation=[{on=\"left\", stiffness={normal=3}}]"}),
                    ContainsSubstring("foundation[0].on: found \"left\", a group on the axis"));
  CHECK_THROWS_WITH(
      test::Ready(block, {axisymmetric, flat, "clamp=[{on=\"left\", value=[\"0.1*t\", \"0\"]}]"}),
      ContainsSubstring("is on the axis, where the radial displacement is 0"));
}
