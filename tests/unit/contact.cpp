#include "base/error.h"
#include "contact/condensed_vi.h"
#include "contact/full_vi.h"
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <random>

using namespace signorini;
using petsc::check;

namespace {

/// The parts of a contact step on their own.
struct Parts {
  scene::Scene scene;
  mesh::Mesh mesh;
  fem::Space space;
  fem::Clamped clamped;
  petsc::Matrix D;
  Factorisation factorisation;
  contact::Constraints constraints;
  contact::Complementarity complementarity;
  contact::Condensation condensation;

  explicit Parts(const std::vector<std::string>& overrides = {})
      : scene(test::parse(test::source("tests/data/block.toml"), overrides)), mesh(MPI_COMM_WORLD, scene.mesh),
        space(mesh, scene.mesh.degree), clamped(space, scene.clamps),
        D(fem::assemble_step_operator(space, scene.material, scene.time.step)), factorisation(D),
        constraints(space, clamped, *scene.contact), complementarity(constraints, D),
        condensation(constraints, factorisation, space.vector()) {}

  /// r = D y for a target y that presses some candidates into the obstacle and lifts others.
  petsc::Vector pressing(int which) const {
    petsc::Vector y = test::smooth(space, which), r = petsc::zero_like(y);
    check(VecScale(y, 0.5));
    check(VecShift(y, -0.4));
    check(MatMult(D, y, r));
    return r;
  }
};

} // namespace

TEST_CASE("candidates know their gap to a tilted plane", "[contact]") {
  const Parts parts;
  const double n = std::hypot(0.3, 1.0);
  REQUIRE(parts.constraints.count() == 5);
  for (int i = 0; i < parts.constraints.count(); ++i) {
    const double* x = &parts.constraints.points()[static_cast<std::size_t>(3 * i)];
    CHECK(std::abs(x[0] - 0.25 * i) < 1e-10); // ordered by coordinates on any number of ranks
    CHECK(std::abs(parts.constraints.psi()[static_cast<std::size_t>(i)] - (0.3 * x[0] + x[1] + 0.1) / n) < 1e-14);
  }
  petsc::Vector y = parts.space.vector();
  check(VecSet(y, -0.05));
  std::vector<double> gap(5);
  parts.constraints.gap(y, gap);
  for (int i = 0; i < 5; ++i)
    CHECK(std::abs(gap[static_cast<std::size_t>(i)] - (parts.constraints.psi()[static_cast<std::size_t>(i)] - 0.05 * 1.3 / n)) < 1e-14);
  check(VecSet(y, -1));
  CHECK_THROWS_AS(parts.constraints.require_outside(y), UserError);
}

TEST_CASE("the condensed matrix is what D says", "[contact]") {
  const Parts parts;
  const std::size_t m = static_cast<std::size_t>(parts.constraints.count());
  std::vector<double> lambda{1, -2, 0.5, 3, 0.1}, slip(m);
  petsc::Vector force = parts.space.vector(), y = parts.space.vector();
  parts.constraints.add_normal(1, lambda, force);
  parts.factorisation.solve(force, y);
  parts.constraints.normal_components(y, slip);
  for (std::size_t i = 0; i < m; ++i) {
    double product = 0;
    for (std::size_t j = 0; j < m; ++j)
      product += parts.condensation.S()[i * m + j] * lambda[j];
    CHECK(std::abs(product / slip[i] - 1) < 1e-12);
  }
}

TEST_CASE("both VI solvers find the solution, which is complementary", "[contact]") {
  for (const std::vector<std::string>& overrides :
       {std::vector<std::string>{}, {"mesh.degree=2"}, {"mesh.size=0.1", "contact.obstacle.normal=[-1, 0.4]",
                                                        "contact.obstacle.point=[0.8, 0]", "contact.on=boundary"}}) {
    const Parts parts(overrides);
    const contact::CondensedVi condensed(parts.constraints, parts.condensation, parts.factorisation,
                                         parts.complementarity);
    const contact::FullVi full(parts.constraints, parts.D, parts.complementarity);
    int closed = 0, open = 0;
    for (int which = 0; which < 6; ++which) {
      const petsc::Vector r = parts.pressing(which);
      petsc::Vector y = parts.space.vector(), z = parts.space.vector(), defect = parts.space.vector();
      const contact::ContactState a = condensed.solve(r, {}, y), b = full.solve(r, {}, z);
      CHECK(a.active() == b.active());
      CHECK(test::difference(y, z) < 1e-12 * test::largest(y));
      closed += a.count(contact::Status::strong);
      open += a.count(contact::Status::open);
      // D y = r − Nλ with 0 ≤ λ ⟂ g ≥ 0.
      check(MatMult(parts.D, y, defect));
      check(VecAXPY(defect, -1, r));
      parts.constraints.add_normal(1, a.lambda, defect);
      CHECK(test::largest(defect) < 1e-13 * test::largest(r));
      for (std::size_t i = 0; i < a.lambda.size(); ++i) {
        CHECK(a.lambda[i] >= 0);
        CHECK(a.gap[i] >= -1e-14);
        CHECK(std::abs(a.lambda[i] * a.gap[i]) < 1e-14);
      }
    }
    CHECK(closed > 0);
    CHECK(open > 0);
  }
}

TEST_CASE("a warm start changes the effort, not the solution", "[contact]") {
  const Parts parts({"mesh.size=0.1"});
  const contact::CondensedVi solver(parts.constraints, parts.condensation, parts.factorisation, parts.complementarity);
  const petsc::Vector r = parts.pressing(2);
  petsc::Vector cold = parts.space.vector(), warm = parts.space.vector();
  const contact::ContactState first = solver.solve(r, {}, cold);
  REQUIRE(first.count(contact::Status::strong) > 1);
  CHECK(first.vi_iterations > 0);
  CHECK(solver.solve(r, first, warm).vi_iterations == 0);
  CHECK(test::difference(cold, warm) < 1e-14 * test::largest(cold)); // MUMPS sums in no fixed order
}

TEST_CASE("touching without a force is weak contact", "[contact]") {
  const Parts parts;
  // The displacement that closes every gap exactly, held by its own load: g = 0, λ = 0.
  petsc::Vector y = parts.space.vector(), r = parts.space.vector(), solution = parts.space.vector();
  parts.space.interpolate(scene::Field({"0", "-0.1 - 0.3*x - y"}, "test", false), 0, y);
  check(MatMult(parts.D, y, r));
  const contact::CondensedVi solver(parts.constraints, parts.condensation, parts.factorisation, parts.complementarity);
  const contact::ContactState state = solver.solve(r, {}, solution);
  CHECK(state.count(contact::Status::weak) == parts.constraints.count());
  CHECK(static_cast<int>(state.active().size()) == parts.constraints.count());
}

TEST_CASE("sliding solves move along the obstacle with normal forces alone", "[contact]") {
  const Parts parts({"mesh.degree=2"});
  const contact::ActiveSet set{1, 2, 5};
  const petsc::Vector r = parts.pressing(3);
  petsc::Vector p = parts.space.vector(), defect = parts.space.vector();
  parts.condensation.solve_sliding(r, set, p);
  std::vector<double> normal(static_cast<std::size_t>(parts.constraints.count()));
  parts.constraints.normal_components(p, normal);
  for (int i : set)
    CHECK(std::abs(normal[static_cast<std::size_t>(i)]) < 1e-13 * test::largest(p));
  // What is left of r − D p must be normal forces on the set.
  check(MatMult(parts.D, p, defect));
  check(VecAYPX(defect, -1, r));
  parts.constraints.normal_components(defect, normal);
  for (std::size_t i = 0; i < normal.size(); ++i)
    if (std::ranges::find(set, static_cast<int>(i)) == set.end())
      normal[i] = 0;
  CHECK(test::largest(defect) > 1e-3 * test::largest(r));
  parts.constraints.add_normal(-1, normal, defect);
  CHECK(test::largest(defect) < 1e-13 * test::largest(r));
}

namespace {

/// A PETSc option for as long as this object lives.
struct Option {
  const char* name;
  Option(const char* n, const char* value) : name(n) { check(PetscOptionsSetValue(nullptr, name, value)); }
  ~Option() { (void)PetscOptionsClearValue(nullptr, name); }
};

} // namespace

TEST_CASE("a VI that does not converge ends with reason and residual", "[contact]") {
  const Option option("-full_vi_snes_max_it", "0");
  const Parts parts;
  const contact::FullVi solver(parts.constraints, parts.D, parts.complementarity);
  petsc::Vector y = parts.space.vector();
  CHECK_THROWS_AS(solver.solve(parts.pressing(2), {}, y), SolverFailure);
}

TEST_CASE("where PETSc's VI solver gives up the set is settled all the same", "[contact]") {
  const Parts parts({"mesh.size=0.1"});
  const auto solve = [&](petsc::Vector& y) {
    const contact::CondensedVi solver(parts.constraints, parts.condensation, parts.factorisation, parts.complementarity);
    return solver.solve(parts.pressing(2), {}, y);
  };
  petsc::Vector y = parts.space.vector(), z = parts.space.vector();
  const contact::ContactState usual = solve(y);
  const Option option("-condensed_vi_snes_max_it", "0");
  const contact::ContactState other = solve(z);
  CHECK(usual.count(contact::Status::strong) > 1);
  CHECK(other.active() == usual.active());
  CHECK(test::difference(y, z) < 1e-13 * test::largest(y));
}
