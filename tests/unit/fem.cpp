// SPDX-License-Identifier: GPL-3.0-or-later
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>

using namespace signorini;
using Catch::Matchers::ContainsSubstring;
using petsc::check;
using petsc::dot;

namespace {

struct Body {
  scene::Scene scene;
  std::shared_ptr<const problem::SpaceDiscretisation> shared;
  fem::Space space;
  fem::Operators operators;
  explicit Body(int degree, const char* file = "tests/data/block.toml")
      : scene(test::parse(test::source(file))), shared(test::discretised(scene)), space(shared->mesh, degree),
        operators(fem::assemble_operators(space, scene.materials, true)) {}

  petsc::Vector field(const scene::Components& components) const {
    petsc::Vector x = space.vector();
    space.interpolate(scene::Field(components, "test", false), 0, x);
    return x;
  }
};

double energy(Mat matrix, Vec x) {
  petsc::Vector product = petsc::zero_like(x);
  check(MatMult(matrix, x, product));
  return dot(x, product);
}

} // namespace

TEST_CASE("operators integrate what they should", "[fem]") {
  const int degree = GENERATE(1, 2);
  CAPTURE(degree);
  const Body body(degree);
  const scene::Material& material = body.scene.materials.front();
  const petsc::Vector unit = body.field({"1", "0"}), linear = body.field({"x", "y"}),
                      shear = body.field({"y", "0"});
  CHECK(std::abs(energy(*body.operators.W, unit) - 1) < 1e-13);
  CHECK(std::abs(energy(body.operators.M, unit) - material.density) < 1e-13);
  CHECK(std::abs(energy(*body.operators.W, linear) - 2.0 / 3) < 1e-13);
  const double lambda =
      material.young * material.poisson / ((1 + material.poisson) * (1 - 2 * material.poisson));
  const double mu = material.young / (2 * (1 + material.poisson));
  // eps = I: tr = 2 in plane strain, so (2 lambda + 2 mu) 2; eps = sym(e1 e2): 2 mu / 2.
  CHECK(std::abs(energy(body.operators.A, linear) / (4 * lambda + 4 * mu) - 1) < 1e-13);
  CHECK(std::abs(energy(body.operators.A, shear) / mu - 1) < 1e-13);
  const double kappa = material.viscosity->bulk, eta = material.viscosity->shear;
  CHECK(std::abs(energy(*body.operators.B, linear) / (4 * (kappa - 2 * eta / 3) + 4 * eta) - 1) < 1e-13);
  CHECK(std::abs(energy(*body.operators.B, shear) / eta - 1) < 1e-13);
}

TEST_CASE("operators integrate what they should in space", "[fem]") {
  const int degree = GENERATE(1, 2);
  CAPTURE(degree);
  const Body body(degree, "tests/data/manufactured-space.toml");
  const scene::Material& material = body.scene.materials.front();
  const petsc::Vector unit = body.field({"0", "0", "1"}), linear = body.field({"x", "y", "z"}),
                      shear = body.field({"0", "z", "0"});
  CHECK(std::abs(energy(*body.operators.W, unit) - 1) < 1e-13);
  CHECK(std::abs(energy(body.operators.M, unit) - material.density) < 1e-13);
  CHECK(std::abs(energy(*body.operators.W, linear) - 1) < 1e-13);
  const double lambda =
      material.young * material.poisson / ((1 + material.poisson) * (1 - 2 * material.poisson));
  const double mu = material.young / (2 * (1 + material.poisson));
  // eps = I: tr = 3, so (3 lambda + 2 mu) 3; eps = sym(e2 e3): 2 mu / 2.
  CHECK(std::abs(energy(body.operators.A, linear) / (9 * lambda + 6 * mu) - 1) < 1e-13);
  CHECK(std::abs(energy(body.operators.A, shear) / mu - 1) < 1e-13);
  CHECK(std::abs(energy(*body.operators.B, linear) / (9 * material.viscosity->bulk) - 1) < 1e-13); // no shear
  CHECK(std::abs(energy(*body.operators.B, shear) / material.viscosity->shear - 1) < 1e-13);
  for (const scene::Components& rigid : {scene::Components{"1", "0", "0"},
                                         {"0", "0", "1"},
                                         {"-y", "x", "0"},
                                         {"0", "-z", "y"},
                                         {"z", "0", "-x"}}) {
    CHECK(energy(body.operators.A, body.field(rigid)) < 1e-12);
    CHECK(energy(*body.operators.B, body.field(rigid)) < 1e-12);
  }
}

TEST_CASE("rigid motions have no elastic or viscous energy", "[fem]") {
  const int degree = GENERATE(1, 2);
  CAPTURE(degree);
  const Body body(degree);
  for (const scene::Components& rigid : {scene::Components{"1", "0"}, {"0", "1"}, {"-y", "x"}}) {
    CHECK(energy(body.operators.A, body.field(rigid)) < 1e-12 * body.scene.materials.front().young);
    CHECK(energy(*body.operators.B, body.field(rigid)) < 1e-12);
  }
}

TEST_CASE("a linear function is embedded in degree 2 as itself", "[fem]") {
  for (const auto& [file, components] :
       {std::pair("tests/data/block.toml", scene::Components{"1 + 2*x - y", "3*y - x"}),
        std::pair("tests/data/cube.toml", scene::Components{"1 + 2*x - y", "3*y - x + z", "2 - 4*z + y"})}) {
    INFO(file);
    const Body linear(1, file), quadratic(2, file);
    const petsc::Vector u = linear.field(components), wanted = quadratic.field(components);
    petsc::Vector found = quadratic.space.vector();
    petsc::check(MatMult(fem::embedding(linear.space, quadratic.space), u, found));
    REQUIRE(test::largest(wanted) > 0.1);
    CHECK(test::difference(found, wanted) < 1e-14 * test::largest(wanted));
  }
}

TEST_CASE("parts with the same material are one body", "[fem]") {
  for (const char* name : {"tests/data/parts.geo", "tests/data/parts-space.geo"})
    for (int degree : {1, 2}) {
      CAPTURE(name, degree);
      const mesh::Mesh mesh(MPI_COMM_WORLD, {.file = test::source(name), .size = 0.4});
      const fem::Space space(mesh, degree);
      const scene::Material material{std::nullopt, 2, 3, 0.3, scene::Viscosity{0.4, 0.7}};
      const fem::Operators one = fem::assemble_operators(space, {material}, true);
      const petsc::Matrix D = fem::assemble_step_operator(space, {material}, 0.3);
      std::vector<scene::Material> parts(2, material);
      parts[0].on = "left", parts[1].on = "right";
      const fem::Operators two = fem::assemble_operators(space, parts, true);
      const petsc::Vector x = test::smooth(space, 1);
      const auto same = [&](Mat a, Mat b) {
        petsc::Vector y = petsc::zero_like(x), z = petsc::zero_like(x);
        check(MatMult(a, x, y));
        check(MatMult(b, x, z));
        CHECK(test::largest(y) > 0);
        CHECK(test::difference(y, z) < 1e-13 * test::largest(y)); // sums in another order
      };
      same(*one.W, *two.W);
      same(one.M, two.M);
      same(one.A, two.A);
      same(*one.B, *two.B);
      same(D, fem::assemble_step_operator(space, parts, 0.3));
      CHECK(std::abs(*two.uniform_density - 2) < 1e-13);
    }
}

TEST_CASE("every part has the mass and the energies of its own material", "[fem]") {
  const mesh::Mesh mesh(MPI_COMM_WORLD, {.file = test::source("tests/data/parts.geo"), .size = 0.3});
  std::vector<scene::Material> materials{{"left", 2, 3, 0.3, std::nullopt},
                                         {"right", 7, 5, 0.2, scene::Viscosity{0.4, 0.9}}};
  for (int degree : {1, 2}) {
    CAPTURE(degree);
    const fem::Space space(mesh, degree);
    const fem::Operators operators = fem::assemble_operators(space, materials, false);
    const auto field = [&](const scene::Components& components) {
      petsc::Vector x = space.vector();
      space.interpolate(scene::Field(components, "test", false), 0, x);
      return x;
    };
    CHECK_FALSE(operators.uniform_density);
    CHECK(std::abs(energy(operators.M, field({"0", "1"})) / (2 + 7) - 1) < 1e-13);
    CHECK(std::abs(energy(operators.M, field({"x", "0"})) / (2 * 1.0 / 3 + 7 * 7.0 / 3) - 1) < 1e-13);
    // Strain e1 e1 in one part alone: lambda + 2 mu, and of the viscosity kappa - 2 eta/3 + 2 eta.
    const petsc::Vector left = field({"min(x, 1)", "0"}), right = field({"max(x, 1)", "0"});
    const auto modulus = [](const scene::Material& m) {
      return m.young * (1 - m.poisson) / ((1 + m.poisson) * (1 - 2 * m.poisson));
    };
    CHECK(std::abs(energy(operators.A, left) / modulus(materials[0]) - 1) < 1e-13);
    CHECK(std::abs(energy(operators.A, right) / modulus(materials[1]) - 1) < 1e-13);
    CHECK(std::abs(energy(*operators.B, left)) < 1e-13);
    CHECK(std::abs(energy(*operators.B, right) / (0.4 + 4.0 / 3 * 0.9) - 1) < 1e-13);
    constexpr double tau = 0.3;
    const petsc::Matrix D = fem::assemble_step_operator(space, materials, tau);
    const petsc::Vector x = test::smooth(space, 1);
    const double expected =
        energy(operators.M, x) + tau / 2 * energy(*operators.B, x) + tau * tau / 4 * energy(operators.A, x);
    CHECK(std::abs(energy(D, x) / expected - 1) < 1e-13);
    const petsc::Matrix R = fem::shifted(operators.A, D, 0.7);
    CHECK(std::abs(energy(R, x) / (expected - 0.7 * energy(operators.A, x)) - 1) < 1e-13);
  }
  materials[1].viscosity.reset();
  materials[1].density = 2;
  const fem::Operators elastic = fem::assemble_operators(fem::Space(mesh, 1), materials, true);
  CHECK_FALSE(elastic.B);
  CHECK(std::abs(*elastic.uniform_density - 2) < 1e-13);
}

TEST_CASE("a cell without a material, or with two, is refused with its place", "[fem]") {
  const std::string middle = "at (1."; // of a cell on the right
  const char* name = GENERATE(as<const char*>{}, "tests/data/parts.geo", "tests/data/parts-space.geo");
  CAPTURE(name);
  const mesh::Mesh mesh(MPI_COMM_WORLD, {.file = test::source(name), .size = 0.4});
  const auto on = [](const char* group) { return scene::Material{group, 1, 1, 0, std::nullopt}; };
  const scene::Material left = on("left"), right = on("right"), body = on("body"), end = on("end");
  CHECK(fem::parts(mesh, {right, left}).size() == 2);
  CHECK_THROWS_WITH(fem::parts(mesh, {left}), ContainsSubstring(middle) && ContainsSubstring("no group") &&
                                                  ContainsSubstring("(left)"));
  CHECK_THROWS_WITH(fem::parts(mesh, {body, right}),
                    ContainsSubstring(middle) && ContainsSubstring("\"body\" and \"right\""));
  CHECK_THROWS_WITH(fem::parts(mesh, {left, end}),
                    ContainsSubstring("material[1].on") && ContainsSubstring("\"end\""));
}

TEST_CASE("the L2 product over a part or a surface", "[fem]") {
  for (const auto& [name, dim] : {std::pair{"tests/data/parts.geo", 2}, {"tests/data/parts-space.geo", 3}})
    for (int degree : {1, 2}) {
      CAPTURE(name, dim, degree);
      const mesh::Mesh mesh(MPI_COMM_WORLD, {.file = test::source(name), .size = 0.4});
      const fem::Space space(mesh, degree);
      const petsc::Vector unit = space.vector(), linear = space.vector();
      scene::Components first(static_cast<std::size_t>(dim), "0");
      first.back() = "1";
      space.interpolate(scene::Field(first, "test", false), 0, unit);
      first.back() = "x";
      space.interpolate(scene::Field(first, "test", false), 0, linear);
      const auto holds = [&](const char* group, double size, double second_moment) {
        const petsc::Matrix W = fem::assemble_L2(space, group, "test");
        CHECK(petsc::component(W) != nullptr);
        CHECK(std::abs(energy(W, unit) - size) < 1e-13);
        CHECK(std::abs(energy(W, linear) - second_moment) < 1e-13);
      };
      // Size, and the integral of x squared.
      holds("body", 2, 8.0 / 3);
      holds("left", 1, 1.0 / 3);
      holds("right", 1, 7.0 / 3);
      holds("interface", 1, 1);
      holds("end", 1, 4);
      const double sides = dim == 2 ? 2 : 4; // along x, beside the two ends
      holds("boundary", 2 + sides * 2, 4 + sides * 8 / 3);
    }
}

TEST_CASE("the L2 product over a surface has entries for the surface's own nodes alone", "[fem]") {
  const Body body(1); // the unit square at element size 0.25
  const petsc::Matrix W = fem::assemble_L2(body.space, "bottom", "test");
  MatInfo info;
  check(MatGetInfo(petsc::component(W), MAT_GLOBAL_SUM, &info));
  CHECK(info.nz_used == 5 + 2 * 4); // 5 nodes, 4 edges
  const petsc::Vector behind = body.field({"0", "y"});
  CHECK(energy(W, behind) == 0);
}

TEST_CASE("the step operator is m + tau/2 b + tau^2/4 a", "[fem]") {
  const Body body(2);
  constexpr double tau = 0.3;
  const petsc::Vector x = test::smooth(body.space, 1);
  const double expected = energy(body.operators.M, x) + tau / 2 * energy(*body.operators.B, x) +
                          tau * tau / 4 * energy(body.operators.A, x);
  CHECK(std::abs(energy(fem::assemble_step_operator(body.space, body.scene.materials, tau), x) / expected -
                 1) < 1e-13);
  scene::Material elastic = body.scene.materials.front();
  elastic.viscosity.reset();
  CHECK_FALSE(fem::assemble_operators(body.space, {elastic}, false).B);
  const double without = energy(body.operators.M, x) + tau * tau / 4 * energy(body.operators.A, x);
  CHECK(std::abs(energy(fem::assemble_step_operator(body.space, {elastic}, tau), x) / without - 1) < 1e-13);
}

TEST_CASE("decoupled dofs are held and the rest is untouched", "[fem]") {
  const Body body(1);
  const fem::DirichletDofs clamped(body.space,
                                   {{.on = "rest", .components = std::nullopt, .value = std::nullopt}});
  petsc::Matrix D = fem::assemble_step_operator(body.space, body.scene.materials, 0.1);
  petsc::Vector x = test::smooth(body.space, 2), whole = petsc::zero_like(x), cut = petsc::zero_like(x);
  clamped.clear(x);
  check(MatMult(D, x, whole));
  clamped.clear(whole);
  clamped.decouple(D);
  check(MatMult(D, x, cut));
  CHECK(test::largest(whole) > 0);
  CHECK(test::difference(whole, cut) < 1e-14);
}
