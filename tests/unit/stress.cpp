// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/dolfinx_versions.h"
#include "contact/pressure.h"
#include "fem/stress_recovery.h"
#include "fixtures.h"
#include "mesh/simplex.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/mesh/Mesh.h>
#include <numeric>

// dolfinx 0.9 has `using namespace dolfinx` in a header, which makes names from outside ambiguous.
namespace signorini {
using petsc::check;

namespace {

using Tensor = std::array<double, 9>;

/// An elastic material and a viscous one, which may relax.
std::vector<scene::Material> two_materials(std::vector<scene::Branch> prony) {
  std::vector<scene::Material> both{{"left", 2, 3, 0.3, std::nullopt},
                                    {"right", 7, 5, 0.2, scene::Viscosity{0.4, 0.9}}};
  both.back().prony = std::move(prony);
  return both;
}

/// Two squares or cubes, of which the first is elastic and the second viscous too.
struct Body {
  mesh::Mesh mesh;
  fem::Space space;
  std::vector<scene::Material> materials;
  fem::CellFields fields;
  Body(int dim, int degree, std::vector<scene::Branch> prony = {})
      : mesh(MPI_COMM_WORLD,
             {.file = test::source(dim == 2 ? "tests/data/parts.geo" : "tests/data/parts-space.geo"),
              .size = 0.4}),
        space(mesh, degree), materials(two_materials(std::move(prony))),
        fields(space, fem::parts(mesh, materials)) {}

  petsc::Vector motion(scene::Components components) const {
    components.resize(static_cast<std::size_t>(space.dim()), "0");
    petsc::Vector x = space.vector();
    space.interpolate(scene::Field(components, "test", false), 0, x);
    return x;
  }
  /// Calls visit(cell, material, the field's components, midpoint) for every cell of this rank.
  template <class Visit>
  void for_each_cell(fem::CellField field, Visit&& visit) {
    const fem::Shape shape = fem::CellFields::shape(field);
    const std::size_t components = shape.empty() ? 1 : 9;
    const std::span<const double> values = fields(field);
    const auto dofs = fem::cellwise(mesh, shape)->dofmap();
    const std::vector<double> middle = space.midpoints();
    for (const fem::Part& part : fem::parts(mesh, materials))
      for (const std::int32_t cell : part.cells) {
        const auto at = static_cast<std::size_t>(dofs->cell_dofs(cell).front());
        visit(cell, part.material, values.subspan(components * at, components),
              &middle[3 * static_cast<std::size_t>(cell)]);
      }
  }
};

/// Volume of a cell.
double volume(const mesh::Mesh& mesh, std::int32_t cell) {
  const auto& geometry = mesh.dolfinx()->geometry();
  const auto nodes = dolfinx_versions::cell_nodes(geometry);
  const mesh::Simplex simplex(mesh.dim(), [&](int i) {
    return &geometry.x()[3 * static_cast<std::size_t>(
                                 nodes(static_cast<std::size_t>(cell), static_cast<std::size_t>(i)))];
  });
  return simplex.abs_determinant() / (mesh.dim() == 2 ? 2 : 6);
}

double contract(std::span<const double> a, std::span<const double> b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// Adds the stress of an isotropic material with the moduli K and G, deviator and volume apart.
void add_isotropic(double K, double G, const Tensor& strain, Tensor& stress) {
  const double trace = strain[0] + strain[4] + strain[8];
  for (std::size_t i = 0; i < 9; ++i) {
    const double on = i % 4 == 0;
    stress[i] += 2 * G * (strain[i] - on * trace / 3) + on * K * trace;
  }
}

/// Hooke's law by E and ν, Newton's by κ and η, and the branches of a Prony series with the strains
/// `internal`, as they stand in textbooks.
Tensor law(const scene::Material& material, const Tensor& strain, const Tensor& rate,
           std::span<const Tensor> internal = {}) {
  const scene::Viscosity viscosity = material.viscosity.value_or(scene::Viscosity{});
  const double K = material.young / (3 * (1 - 2 * material.poisson)),
               G = material.young / (2 * (1 + material.poisson));
  Tensor stress{};
  add_isotropic(viscosity.bulk, viscosity.shear, rate, stress);
  double left_K = 1, left_G = 1;
  for (std::size_t j = 0; j < material.prony.size(); ++j) {
    const scene::Branch& branch = material.prony[j];
    left_K -= branch.k, left_G -= branch.g;
    add_isotropic(branch.k * K, branch.g * G, internal[j], stress);
  }
  add_isotropic(left_K * K, left_G * G, strain, stress);
  return stress;
}

double von_mises(const Tensor& s) {
  const double normal = std::pow(s[0] - s[4], 2) + std::pow(s[4] - s[8], 2) + std::pow(s[8] - s[0], 2),
               shear = s[1] * s[1] + s[2] * s[2] + s[5] * s[5];
  return std::sqrt(normal / 2 + 3 * shear);
}

} // namespace

TEST_CASE("strain and stress of linear motions are those of the law, in the plane with the third axis' too",
          "[fem]") {
  const Tensor strain_2{0.1, 0.15, 0, 0.15, -0.3, 0, 0, 0, 0}, rate_2{-0.7, 0.5, 0, 0.5, 0.2, 0, 0, 0, 0},
      strain_3{0.1, 0.15, -0.05, 0.15, -0.3, 0.3, -0.05, 0.3, 0.25},
      rate_3{-0.7, 0.5, 0.2, 0.5, 0.2, -0.15, 0.2, -0.15, 0.9};
  for (const int dim : {2, 3})
    for (const int degree : {1, 2}) {
      CAPTURE(dim, degree);
      Body body(dim, degree);
      const std::string z = dim == 3 ? "1" : "0";
      body.fields.set(
          body.motion(
              {"0.1*x + 0.5*y - 0.3*z*" + z, "-0.2*x - 0.3*y + 0.7*z*" + z, "0.2*x - 0.1*y + 0.25*z"}),
          body.motion({"-0.7*x + y + 0.1*z*" + z, "0.2*y - 0.5*z*" + z, "0.3*x + 0.2*y + 0.9*z"}));
      const Tensor &strain = dim == 2 ? strain_2 : strain_3, &rate = dim == 2 ? rate_2 : rate_3;
      long seen = 0;
      double off = 0;
      const auto compare = [&](std::span<const double> found, std::span<const double> expected) {
        for (std::size_t i = 0; i < found.size(); ++i)
          off = std::max(off, std::abs(found[i] - expected[i]));
        ++seen;
      };
      body.for_each_cell(fem::CellField::strain,
                         [&](auto, const auto&, auto found, const double*) { compare(found, strain); });
      body.for_each_cell(fem::CellField::stress, [&](auto, const auto& material, auto found, const double*) {
        const Tensor expected = law(material, strain, rate);
        if (dim == 2 && !material.viscosity) // as engineers know it
          CHECK(std::abs(found[8] - material.poisson * (found[0] + found[4])) < 1e-13);
        compare(found, expected);
      });
      body.for_each_cell(fem::CellField::von_mises,
                         [&](auto, const auto& material, auto found, const double*) {
                           compare(found, std::array{von_mises(law(material, strain, rate))});
                         });
      CHECK(test::total(seen) == 3 * body.mesh.cells());
      CHECK(test::largest(std::array{off}) < 1e-13); // of stresses up to 3 Pa
    }
}

TEST_CASE("branches of a material that relaxes add their stress to that of its long-term moduli", "[fem]") {
  const int dim = GENERATE(2, 3);
  const int degree = GENERATE(1, 2);
  CAPTURE(dim, degree);
  Body body(dim, degree, {{0.3, 0.1, 1}, {0.2, 0, 2}});
  const petsc::Vector y = body.motion({"0.1*x + 0.5*y", "-0.2*x - 0.3*y"}),
                      v = body.motion({"-0.7*x + y", "0.2*y"});
  const Tensor strain{0.1, 0.15, 0, 0.15, -0.3, 0, 0, 0, 0}, rate{-0.7, 0.5, 0, 0.5, 0.2, 0, 0, 0, 0};
  petsc::Series q;
  q.push_back(body.motion({"0.4*x - 0.1*y", "0.3*y"}));
  q.push_back(body.motion({"-0.2*x", "0.6*x + 0.1*y"}));
  const std::array internal{Tensor{0.4, -0.05, 0, -0.05, 0.3, 0, 0, 0, 0},
                            Tensor{-0.2, 0.3, 0, 0.3, 0.1, 0, 0, 0, 0}};
  body.fields.set(y, v, q);
  long relaxing = 0;
  double off = 0;
  const auto compare = [&](std::span<const double> found, std::span<const double> expected) {
    for (std::size_t i = 0; i < found.size(); ++i)
      off = std::max(off, std::abs(found[i] - expected[i]));
  };
  // The von Mises stress first, which asks for the stress itself.
  body.for_each_cell(fem::CellField::von_mises, [&](auto, const auto& material, auto found, const double*) {
    compare(found, std::array{von_mises(law(material, strain, rate, internal))});
  });
  body.for_each_cell(fem::CellField::stress, [&](auto, const auto& material, auto found, const double*) {
    compare(found, law(material, strain, rate, internal));
    relaxing += material.relaxes();
  });
  CHECK(test::total(relaxing) > 0);
  CHECK(test::total(relaxing) < body.mesh.cells());
  CHECK(test::largest(std::array{off}) < 1e-13); // of stresses up to 5 Pa
  // Without internal displacements the branches have no stress.
  body.fields.set(y, v);
  off = 0;
  const std::array<Tensor, 2> none{};
  body.for_each_cell(fem::CellField::von_mises, [&](auto, const auto& material, auto found, const double*) {
    compare(found, std::array{von_mises(law(material, strain, rate, none))});
  });
  CHECK(test::largest(std::array{off}) < 1e-13);
  CHECK_THROWS_AS(body.fields.set(y, v, std::span(q).first(1)), std::logic_error);
}

TEST_CASE("of degree 2 strains are linear in a cell, and its value is that of the midpoint", "[fem]") {
  Body body(3, 2);
  body.fields.set(body.motion({"x^2 - y*z", "x*y + 2*z^2", "z*x - y^2"}), body.motion({"0", "0", "0"}));
  double off = 0;
  body.for_each_cell(fem::CellField::strain, [&](auto, const auto&, auto found, const double* m) {
    const double x = m[0], y = m[1], z = m[2], xy = (-z + y) / 2, xz = (-y + z) / 2, yz = (4 * z - 2 * y) / 2;
    const Tensor expected{2 * x, xy, xz, xy, x, yz, xz, yz, x};
    for (std::size_t i = 0; i < 9; ++i)
      off = std::max(off, std::abs(found[i] - expected[i]));
  });
  CHECK(test::largest(std::array{off}) < 1e-12);
}

TEST_CASE("stress does the work of the operators A and B", "[fem]") {
  const int dim = GENERATE(2, 3);
  CAPTURE(dim);
  Body body(dim, 1); // whose strains are constant on each cell
  const fem::Operators operators = fem::assemble_operators(body.space, body.materials, false);
  const petsc::Vector y = test::smooth(body.space, 1), v = test::smooth(body.space, 2),
                      w = test::smooth(body.space, 3);
  check(VecAXPY(w, 1, y)); // which let both forms be of the size of their energies
  check(VecAXPY(w, 1, v));
  body.fields.set(w, w);
  std::map<std::int32_t, std::vector<double>> virtual_strain;
  body.for_each_cell(fem::CellField::strain, [&](auto cell, const auto&, auto found, const double*) {
    virtual_strain[cell].assign(found.begin(), found.end());
  });
  body.fields.set(y, v);
  double work = 0;
  body.for_each_cell(fem::CellField::stress, [&](auto cell, const auto&, auto found, const double*) {
    work += volume(body.mesh, cell) * contract(found, virtual_strain[cell]);
  });
  MPI_Allreduce(MPI_IN_PLACE, &work, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  petsc::Vector forces = petsc::zero_like(y);
  check(MatMult(operators.A, y, forces));
  const double elastic = petsc::dot(forces, w);
  check(MatMult(*operators.B, v, forces));
  const double viscous = petsc::dot(forces, w);
  REQUIRE(std::min(std::abs(elastic), std::abs(viscous)) > 0.1);
  CHECK(std::abs(work / (elastic + viscous) - 1) < 1e-12);
}

TEST_CASE("nodal forces of a uniform pressure give it at every candidate, and areas add up to the surface",
          "[contact]") {
  for (const char* file : {"tests/data/block.toml", "tests/data/cube.toml"})
    for (const char* degree : {"mesh.degree=1", "mesh.degree=2"}) {
      CAPTURE(file, degree);
      const test::Ready ready(file, {degree});
      const fem::Space& space = ready.problem.space;
      const contact::ContactPairs& pairs = *ready.problem.stepper.pairs();
      const contact::Pressure pressure(space, pairs, ready.scene.contacts);
      const std::vector<double>& area = pressure.area();
      CHECK(std::abs(std::reduce(area.begin(), area.end()) - 1) < 1e-13); // of a unit square's or cube's side
      const auto corners = std::ranges::count_if(area, [](double a) { return a > 0; });
      CHECK((space.degree() == 1) == (corners == pairs.count()));
      // Forces by the L2 product with the function that is p everywhere; twice that by another unit of λ.
      constexpr double p = 3.5, impulse = 0.5;
      const petsc::Matrix W = fem::assemble_L2(space, "bottom", "test");
      const petsc::Vector one = space.vector(), sum = space.vector();
      check(VecSet(one, p));
      check(MatMult(W, one, sum));
      std::vector<double> lambda(area.size(), 0.0);
      {
        const petsc::ReadArray forces(sum);
        for (std::size_t i = 0; i < lambda.size(); ++i)
          if (const int dof = pairs.local_dofs()[i]; dof >= 0)
            lambda[i] = impulse * forces[static_cast<std::size_t>(dof)];
      }
      MPI_Allreduce(MPI_IN_PLACE, lambda.data(), static_cast<int>(lambda.size()), MPI_DOUBLE, MPI_SUM,
                    space.comm());
      for (const double found : pressure(lambda, impulse))
        CHECK(std::abs(found / p - 1) < 1e-12);
      // Any forces: none is lost, and no pressure is negative.
      for (std::size_t i = 0; i < lambda.size(); ++i)
        lambda[i] = static_cast<double>(i * i % 7);
      const std::vector<double> found = pressure(lambda, 1);
      CHECK(std::abs(std::inner_product(found.begin(), found.end(), area.begin(), 0.0) /
                         std::reduce(lambda.begin(), lambda.end()) -
                     1) < 1e-13);
      CHECK(std::ranges::min(found) >= 0);
      const std::vector<double> field = contact::at_nodes(space, pairs, found);
      REQUIRE(field.size() == static_cast<std::size_t>(space.owned_nodes()));
      for (std::size_t node = 0; node < field.size(); ++node)
        if (space.points()[3 * node + static_cast<std::size_t>(space.dim()) - 1] > 1e-9)
          CHECK(field[node] == 0);
      CHECK(test::largest(field) == std::ranges::max(found));
    }
}

TEST_CASE("a node of two surfaces has the area of each and, as a field, the larger pressure", "[contact]") {
  const test::Ready ready(
      "tests/data/block.toml",
      {"mesh.degree=2",
       "contact=[{on=\"bottom\", obstacle={shape=\"half-space\", point=[0, -0.1], normal=[0, 1]}}, "
       "{on=\"left\", obstacle={shape=\"half-space\", point=[-0.1, 0], normal=[1, 0]}}]"});
  const fem::Space& space = ready.problem.space;
  const contact::ContactPairs& pairs = *ready.problem.stepper.pairs();
  const contact::Pressure pressure(space, pairs, ready.scene.contacts);
  const auto corner = std::ranges::find_if(pairs.rows().clusters(),
                                           [](const auto& node) { return node.last - node.first == 2; });
  REQUIRE(corner != pairs.rows().clusters().end());
  const auto first = static_cast<std::size_t>(corner->first);
  // Half of an edge of a quarter of a metre, to whose middle it is as far; the mesher rounds to 1e-12.
  for (const std::size_t i : {first, first + 1}) {
    CAPTURE(i);
    double half = 1;
    for (std::size_t j = 0; j < pressure.area().size(); ++j)
      if (j != i && pairs.obstacle(static_cast<int>(j)) == pairs.obstacle(static_cast<int>(i)))
        half = std::min(half, std::hypot(pairs.points()[3 * j] - pairs.points()[3 * i],
                                         pairs.points()[3 * j + 1] - pairs.points()[3 * i + 1]));
    CHECK(std::abs(half - 0.125) < 1e-12);
    CHECK(std::abs(pressure.area()[i] - half) < 1e-15);
  }
  CHECK(std::abs(std::reduce(pressure.area().begin(), pressure.area().end()) - 2) < 1e-13);
  std::vector<double> values(static_cast<std::size_t>(pairs.count()), 0.0);
  values[first] = 2, values[first + 1] = 3;
  CHECK(test::largest(contact::at_nodes(space, pairs, values)) == 3);
}

TEST_CASE("the stress that is recovered tells the error of the computed one, and its order", "[fem]") {
  for (const int dim : {2, 3}) {
    const auto energy = [&](double size, const char* displacement) {
      const mesh::Mesh mesh(MPI_COMM_WORLD, {.file = test::source(dim == 2 ? "tests/data/parts.geo"
                                                                           : "tests/data/parts-space.geo"),
                                             .size = size});
      const fem::Space space(mesh, 1);
      const std::vector<scene::Material> materials{{"left", 2, 3, 0, std::nullopt},
                                                   {"right", 7, 3, 0, std::nullopt}};
      scene::Components components{displacement};
      components.resize(static_cast<std::size_t>(dim), "0");
      petsc::Vector y = space.vector();
      space.interpolate(scene::Field(components, "test", false), 0, y);
      fem::StressRecovery recovery(space, fem::parts(mesh, materials));
      recovery.add(y, 2);
      recovery.add(y, 1);
      CHECK(std::ssize(recovery.sums()) == mesh.cells());
      return std::accumulate(recovery.sums().begin(), recovery.sums().end(), 0.0) / 3;
    };
    CHECK(energy(0.4, "2*x + 1") < 1e-24); // a uniform stress, in either part
    // y_x = x²: the energy of the error falls as the square of the size.
    const double coarse = energy(0.2, "x^2"), fine = energy(0.1, "x^2");
    INFO(dim << ": " << coarse << ", " << fine);
    CHECK(coarse > 0);
    CHECK(coarse / fine > 3);
    CHECK(coarse / fine < 6);
  }
}

} // namespace signorini
