// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/mass_redistribution.h"
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators_all.hpp>
#include <random>

using namespace signorini;
using petsc::check;

namespace {

const std::string in_a_corner =
    "contact=[{on=\"bottom\", mass=\"massless\", obstacle={shape=\"half-space\", point=[0, -0.1], "
    "normal=[0.1, 1]}}, "
    "{on=\"left\", mass=\"massless\", obstacle={shape=\"half-space\", point=[-0.1, 0], normal=[1, 0.2]}}]";

double product(Mat matrix, Vec x, Vec y) {
  const petsc::Vector work = petsc::zero_like(x);
  check(MatMult(matrix, x, work));
  return petsc::dot(work, y);
}

std::vector<scene::Contact> with(scene::ContactMass mass, std::vector<scene::Contact> contacts) {
  for (scene::Contact& contact : contacts)
    contact.mass = mass;
  return contacts;
}

/// Body, candidates, and the mass before and after it was moved from the contact nodes.
struct Moved {
  scene::Scene scene;
  std::shared_ptr<const problem::SpaceDiscretisation> shared;
  fem::Space space;
  fem::DirichletDofs clamped;
  contact::ContactPairs pairs;
  const contact::ConstraintRows& H = pairs.rows();
  petsc::Matrix before, E, after;

  Moved(const std::string& file, const std::vector<std::string>& overrides,
        scene::ContactMass mass = scene::ContactMass::massless)
      : scene(test::parse(test::source(file), overrides)), shared(test::discretised(scene)),
        space(shared->mesh, scene.mesh.degree), clamped(space, scene.clamps),
        pairs(space, clamped, scene.contacts), before(fem::assemble_mass(space, scene.materials)),
        E(contact::velocity_extrapolation(space, pairs, with(mass, scene.contacts), before)),
        after(contact::redistributed_mass(E, before)) {}

  /// Checks that the masses and their moments with all linear velocity fields, of which rigid motions are
  /// some, are those of the body.
  void keeps_moments() const {
    std::vector<scene::Components> fields;
    for (int c = 0; c < space.dim(); ++c)
      for (const char* value : {"1", "x", "y", "z"}) {
        if (space.dim() == 2 && *value == 'z')
          continue;
        scene::Components field(static_cast<std::size_t>(space.dim()), "0");
        field[static_cast<std::size_t>(c)] = value;
        fields.push_back(field);
      }
    petsc::Vector x = space.vector(), y = space.vector();
    for (const scene::Components& a : fields)
      for (const scene::Components& b : fields) {
        space.interpolate(scene::Field(a, "test", false), 0, x);
        space.interpolate(scene::Field(b, "test", false), 0, y);
        CHECK(std::abs(product(after, x, y) - product(before, x, y)) < 1e-12);
      }
  }

  /// Force of a row.
  petsc::Vector unit_force(std::size_t row) const {
    std::vector<double> one(static_cast<std::size_t>(H.count()), 0.0);
    one[row] = 1;
    petsc::Vector x = space.vector();
    H.apply(1, one, x);
    return x;
  }
};

/// Random nodal values, the same on any number of ranks only in distribution.
petsc::Vector noise(const fem::Space& space, unsigned seed) {
  petsc::Vector x = space.vector();
  std::mt19937 generator(seed + 1000 * static_cast<unsigned>(space.first_dof()));
  std::uniform_real_distribution<double> uniform(-1, 1);
  const petsc::WriteArray values(x);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = uniform(generator);
  return petsc::copy(x);
}

} // namespace

TEST_CASE("massless contact keeps the mass, its moments and the moments of inertia", "[contact]") {
  for (const auto& [file, overrides] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {"tests/data/block.toml", {}},
           {"tests/data/block.toml", {"mesh.size=0.1", "mesh.degree=2"}},
           {"tests/data/block.toml", {"mesh.size=0.1", in_a_corner}},
           {"tests/data/cube.toml", {}}}) {
    CAPTURE(file, overrides);
    const Moved body(file, overrides);
    REQUIRE(body.pairs.count() > 0);
    body.keeps_moments();
    // None is left where contact acts, none of it is negative, and the rest of the body keeps its own.
    petsc::Vector y = body.space.vector();
    for (std::size_t i = 0; i < static_cast<std::size_t>(body.pairs.count()); ++i) {
      const petsc::Vector x = body.unit_force(i);
      check(MatMult(body.after, x, y));
      CHECK(test::largest(y) < 1e-14 * product(body.before, x, x));
    }
    for (unsigned seed = 0; seed < 5; ++seed)
      CHECK(product(body.after, noise(body.space, seed), noise(body.space, seed)) > 0);
  }
}

TEST_CASE("without tangential mass contact nodes keep that along the normal", "[contact]") {
  const auto [file, overrides] = GENERATE(table<std::string, std::vector<std::string>>(
      {{"tests/data/block.toml", {"contact.friction=0.3"}},
       {"tests/data/block.toml", {"contact.friction=0.3", "mesh.size=0.1", "mesh.degree=2"}},
       {"tests/data/cube.toml", {"contact.friction=0.3"}}}));
  CAPTURE(file, overrides);
  const Moved body(file, overrides, scene::ContactMass::massless_tangential);
  body.keeps_moments();
  petsc::Matrix whole;
  check(MatDuplicate(body.after, MAT_COPY_VALUES, whole.put()));
  contact::add_removed_mass(body.E, body.before, whole);
  const auto m = static_cast<std::size_t>(body.pairs.count());
  REQUIRE(static_cast<std::size_t>(body.H.count()) > m);
  petsc::Vector y = body.space.vector();
  for (std::size_t row = 0; row < static_cast<std::size_t>(body.H.count()); ++row) {
    const petsc::Vector x = body.unit_force(row);
    const double before = product(body.before, x, x);
    check(MatMult(body.after, x, y));
    if (row < m)
      CHECK(product(body.after, x, x) > 0.5 * before);
    else {
      CHECK(test::largest(y) < 1e-14 * before);
      CHECK(std::abs(product(whole, x, x) - before) < 1e-14);
    }
  }
  // E is a projection.
  const petsc::Vector x = noise(body.space, 3);
  petsc::Vector once = petsc::zero_like(x);
  check(MatMult(body.E, x, once));
  check(MatMult(body.E, once, y));
  CHECK(test::difference(once, y) < 1e-12);
  CHECK(test::difference(once, x) > 0.1);
  for (unsigned seed = 0; seed < 5; ++seed)
    CHECK(product(whole, noise(body.space, seed), noise(body.space, seed)) > 0);
}

TEST_CASE("candidates that face away from the obstacle keep their mass", "[contact]") {
  const char* degree = GENERATE(as<const char*>{}, "mesh.degree=1", "mesh.degree=2");
  CAPTURE(degree);
  // All sides of a square are candidates, of which the lower one alone faces the floor.
  const Moved body("tests/data/block.toml",
                   {degree, "contact.on=boundary", "contact.obstacle.normal=[0, 1]"});
  petsc::Vector x = body.space.vector();
  const auto m = static_cast<std::size_t>(body.pairs.count());
  int below = 0;
  for (std::size_t i = 0; i < m; ++i) {
    x = body.unit_force(i);
    const double mass = product(body.after, x, x), before = product(body.before, x, x);
    if (body.pairs.points()[3 * i + 1] < 1e-12) {
      ++below;
      CHECK(std::abs(mass) < 1e-14 * before);
    } else {
      CHECK(mass > 0.1 * before);
    }
  }
  REQUIRE(below > 3);
  REQUIRE(below < static_cast<int>(m) / 2);
  body.space.interpolate(scene::Field({"0", "1"}, "test", false), 0, x);
  CHECK(std::abs(product(body.after, x, x) - 1) < 1e-12); // of the unit square of density 1
}

TEST_CASE("the predictor goes to the nearest place in the norm of the mass", "[forward]") {
  for (const auto& [file, overrides] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {"tests/data/block.toml", {}},
           {"tests/data/block.toml", {"solver.linear=\"iterative\""}},
           {"tests/data/block.toml", {"solver.vi=\"full\""}},
           {"tests/data/block.toml", {"clamp=[{on=\"top\"}]", "initial.velocity=[\"0\", \"0\"]"}},
           {"tests/data/block.toml", {"contact.friction=0.3", "contact.mass=massless-tangential"}},
           {"tests/data/cube.toml", {"contact.friction=0.3", "contact.mass=massless-tangential"}},
           {"tests/data/cube.toml", {}}}) {
    CAPTURE(file, overrides);
    std::vector<std::string> settings = overrides;
    settings.emplace_back("time.scheme=\"contact-stabilized\"");
    const test::Ready ready(file, settings);
    const step::Stepper& stepper = ready.problem.stepper;
    const contact::ContactPairs& pairs = *stepper.pairs();
    const auto m = static_cast<std::size_t>(pairs.count());
    contact::ActiveSet touched;
    step::PredictorProjection::Workspace storage = stepper.predictor()->workspace();
    petsc::Vector x = ready.problem.space.vector(), work = petsc::zero_like(x);
    CHECK_FALSE(stepper.predictor()->jump(pairs.psi(), x, {}, touched, storage));
    CHECK(touched.empty());
    // Half of the candidates are pushed in by as much as they are away, all of them unevenly.
    std::vector<double> push(m), gap(m), normal(m);
    for (std::size_t i = 0; i < m; ++i)
      push[i] = pairs.psi()[i] + (i % 2 ? 0.05 : -0.05);
    pairs.rows().apply(1, push, x);
    stepper.clamped().clear(x);
    const Vec jump = stepper.predictor()->jump(pairs.psi(), x, {}, touched, storage);
    REQUIRE(jump);
    REQUIRE(!touched.empty());
    petsc::Vector z = petsc::copy(x);
    check(VecAXPY(z, 1, jump));
    pairs.rows().gap(pairs.psi(), z, gap);
    for (std::size_t i = 0; i < m; ++i) {
      CHECK(gap[i] > -pairs.gap_tolerance());
      if (std::ranges::find(touched, static_cast<int>(i)) != touched.end())
        CHECK(gap[i] < pairs.gap_tolerance());
    }
    // M (z − x) is made of pushes off the obstacle, at touched candidates alone.
    check(MatMult(stepper.M(), jump, work));
    stepper.clamped().clear(work);
    const double size = test::largest(work);
    pairs.rows().apply_transpose(work, normal);
    for (std::size_t i = 0; i < m; ++i)
      if (std::ranges::find(touched, static_cast<int>(i)) == touched.end())
        normal[i] = 0;
      else
        CHECK(normal[i] < 1e-8 * size);
    pairs.rows().apply(-1, normal, work);
    CHECK(test::largest(work) < 1e-8 * size);
    // The linearised projection: its own transpose with M, and nothing is left of a projected vector.
    const petsc::Vector a = test::smooth(ready.problem.space, 1), b = test::smooth(ready.problem.space, 2);
    stepper.clamped().clear(a);
    stepper.clamped().clear(b);
    petsc::Vector ja = petsc::copy(stepper.predictor()->linearised_jump(touched, a, storage)),
                  jb = petsc::copy(stepper.predictor()->linearised_jump(touched, b, storage));
    const double scale = std::abs(product(stepper.M(), a, b));
    CHECK(std::abs(product(stepper.M(), ja, b) - product(stepper.M(), a, jb)) < 1e-9 * scale);
    check(VecAXPY(ja, 1, a));
    const Vec again = stepper.predictor()->linearised_jump(touched, ja, storage);
    CHECK(test::largest(again) < 1e-9 * test::largest(a));
  }
}
