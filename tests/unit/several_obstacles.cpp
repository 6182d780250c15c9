// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/error.h"
#include "contact/lcp/primal_dual.h"
#include "contact/pairs.h"
#include "contact/placement.h"
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <fmt/format.h>
#include <numbers>

using namespace signorini;
using Catch::Matchers::ContainsSubstring;
using petsc::check;

namespace {

/// A block or cube with several obstacles; `contacts` is a list of tables in TOML.
struct Walls {
  scene::Scene scene;
  std::shared_ptr<const problem::SpaceDiscretisation> shared;
  fem::Space space;
  fem::DirichletDofs clamped;
  petsc::Matrix D;
  contact::ContactPairs pairs;
  const contact::ConstraintRows& H = pairs.rows();

  explicit Walls(const std::string& contacts, const std::string& file = "block.toml",
                 std::vector<std::string> overrides = {})
      : scene(test::parse(test::source("tests/data/" + file), with(std::move(overrides), contacts))),
        shared(test::discretised(scene)), space(shared->mesh, scene.mesh.degree),
        clamped(space, scene.clamps), D(fem::assemble_step_operator(space, scene.materials, scene.time.step)),
        pairs(space, clamped, scene.contacts, scene.time) {}

  static std::vector<std::string> with(std::vector<std::string> overrides, const std::string& contacts) {
    overrides.push_back("contact=[" + contacts + "]");
    return overrides;
  }

  /// `solves`: expected.
  [[nodiscard]] step::SolverChoice solver(scene::LinearMethod linear,
                                          scene::ViMethod vi = scene::ViMethod::condensed,
                                          double solves = 0) const {
    petsc::Matrix same;
    check(MatDuplicate(D, MAT_COPY_VALUES, same.put()));
    scene::Solver settings = scene.solver;
    settings.linear = linear;
    settings.vi = vi;
    return {std::move(same), &pairs, settings, true, solves};
  }

  /// y of the contact step for r, from no contact; `state` becomes its contact.
  petsc::Vector solve(const step::SolverChoice& solver, Vec r, contact::ContactState& state) const {
    petsc::Vector y = space.vector();
    contact::Workspace work = solver.contact()->workspace();
    const contact::ActiveSet none;
    const contact::ContactProblem step{r, pairs.psi(), none, state, y};
    solver.contact()->solve(step, work);
    return y;
  }

  /// r = D y for a motion to one side.
  [[nodiscard]] petsc::Vector pushing(const scene::Components& motion) const {
    petsc::Vector y = space.vector(), r = space.vector();
    space.interpolate(scene::Field(motion, "test", false), 0, y);
    check(MatMult(D, y, r));
    return r;
  }

  /// ‖D y − r + Nλ‖∞ beside ‖r‖∞.
  double defect(Vec r, const contact::ContactState& state, Vec y) const {
    petsc::Vector defect = space.vector();
    check(MatMult(D, y, defect));
    check(VecAXPY(defect, -1, r));
    pairs.rows().apply(1, state.lambda, defect);
    return test::largest(defect) / test::largest(r);
  }
};

std::string half_space(const std::string& on, const std::string& point, const std::string& normal,
                       const std::string& more = "") {
  return fmt::format("{{ on = \"{}\", obstacle = {{ shape = \"half-space\", point = {}, normal = {} }}{} }},",
                     on, point, normal, more);
}

/// The box 0 ≤ x ≤ 1 + right, 0 ≤ y ≤ 1 + above around the unit square.
std::string box(const std::string& left, const std::string& right, const std::string& below,
                const std::string& above) {
  return half_space("boundary", fmt::format("[-{}, 0]", left), "[1, 0]") +
         half_space("boundary", fmt::format("[1.0{}, 0]", right), "[-1, 0]") +
         half_space("boundary", fmt::format("[0, -{}]", below), "[0, 1]") +
         half_space("boundary", fmt::format("[0, 1.0{}]", above), "[0, -1]");
}

} // namespace

TEST_CASE("candidates are numbered by place, then by obstacle", "[contact]") {
  const Walls walls(half_space("left", "[-0.1, 0]", "[1, 0]") + half_space("bottom", "[0, -0.2]", "[0, 1]"));
  const contact::ContactPairs& pairs = walls.pairs;
  REQUIRE(pairs.count() == 10);
  CHECK_FALSE(pairs.rows().dependent());
  // The left side from below, the corner twice, then along the bottom.
  const std::vector<int> obstacles{0, 1, 0, 0, 0, 0, 1, 1, 1, 1}, nodes{0, 0, 1, 2, 3, 4, 5, 6, 7, 8};
  CHECK(pairs.obstacles() == obstacles);
  for (std::size_t i = 0; i < 10; ++i) {
    const bool left = obstacles[i] == 0;
    CHECK(pairs.normals()[2 * i] == (left ? -1 : 0));
    CHECK(pairs.normals()[2 * i + 1] == (left ? 0 : -1));
    CHECK(std::abs(pairs.psi()[i] - (left ? 0.1 : 0.2)) < 1e-12);
    const int row = static_cast<int>(i);
    CHECK(&pairs.rows().cluster(row) == &pairs.rows().clusters()[static_cast<std::size_t>(nodes[i])]);
    CHECK(std::ranges::equal(pairs.rows().force(row), std::span(&pairs.normals()[2 * i], 2)));
  }
  CHECK_FALSE(pairs.rows().clamped());
  CHECK(pairs.first_dofs()[0] == pairs.first_dofs()[1]);
}

TEST_CASE("several obstacles at a node: all solvers find the solution, which is complementary", "[contact]") {
  struct Case {
    std::string contacts;
    scene::Components motion; ///< without contact
    bool dependent;
  };
  const std::string acute = half_space("boundary", "[-0.05, 0]", "[1, 0.3]") +
                            half_space("boundary", "[0, -0.1]", "[0.2, 1]"),
                    hole = acute + half_space("boundary", "[-0.05, -0.1]", "[1, 1]"); // blunts the corner
  for (const auto& [contacts, motion, dependent] :
       {Case{acute, {"-0.4 - 0.1*y", "-0.3"}, false}, Case{acute, {"-0.3", "0.2"}, false},
        Case{hole, {"-0.4", "-0.3 - 0.1*x"}, true}, Case{hole, {"-0.1", "-0.5"}, true},
        Case{box("0.1", "1", "0.1", "1"), {"-0.4*x", "-0.3"}, true},
        // Pressed against all four walls at once, two of them without a gap.
        Case{box("0.0", "0", "0.05", "05"), {"0.4*(x - 0.5)", "0.3*(y - 0.5)"}, true},
        // The same plane three times, once shifted: only one of them carries.
        Case{half_space("bottom", "[0, -0.1]", "[0, 1]") + half_space("bottom", "[3, -0.1]", "[0, 2]") +
                 half_space("bottom", "[0, -0.2]", "[0, 1]"),
             {"0", "-0.4*x"},
             true}}) {
    const Walls walls(contacts, "block.toml", {"mesh.size=0.1"});
    REQUIRE(walls.pairs.rows().dependent() == dependent);
    const petsc::Vector r = walls.pushing(motion);
    contact::ContactState a(walls.pairs.count()), b(walls.pairs.count()), c(walls.pairs.count());
    const step::SolverChoice direct = walls.solver(scene::LinearMethod::direct),
                             iterative = walls.solver(scene::LinearMethod::iterative),
                             on_demand = walls.solver(scene::LinearMethod::iterative,
                                                      scene::ViMethod::condensed, 1e9);
    REQUIRE(on_demand.choice().find("on demand") != std::string::npos);
    const petsc::Vector y = walls.solve(direct, r, a), z = walls.solve(iterative, r, b),
                        w = walls.solve(on_demand, r, c);
    CHECK(test::difference(y, w) < 1e-10 * test::largest(y));
    CHECK(walls.defect(r, c, w) < 1e-9);
    CHECK(a.count(contact::Status::strong) > 1);
    CHECK(test::difference(y, z) < 1e-10 * test::largest(y));
    CHECK(walls.defect(r, a, y) < 1e-12);
    CHECK(walls.defect(r, b, z) < 1e-9);
    for (std::size_t i = 0; i < a.lambda.size(); ++i) {
      CHECK(a.lambda[i] >= -1e-12);
      CHECK(a.gap[i] >= -1e-14);
      CHECK(std::abs(a.lambda[i] * a.gap[i]) < 1e-13);
    }
    // Sliding keeps all of the active set closed, with normal forces alone, dependent or not.
    for (const step::SolverChoice* solver : {&direct, &iterative, &on_demand}) {
      const petsc::Vector q = walls.pushing({"x - y", "1 + x*y"});
      petsc::Vector p = walls.space.vector();
      contact::Workspace work = solver->contact()->workspace();
      const contact::LinearisedContact step{.r = q, .set = a.active, .x = p};
      solver->contact()->solve_linearised(step, work);
      std::vector<double> normal(a.lambda.size());
      walls.H.apply_transpose(p, normal);
      for (int i : a.active)
        CHECK(std::abs(normal[static_cast<std::size_t>(i)]) < 1e-12 * test::largest(p));
      petsc::Vector left = walls.space.vector();
      check(MatMult(walls.D, p, left));
      check(VecAYPX(left, -1, q));
      contact::ActiveSet set = a.active;
      contact::drop_dependent(walls.H, set);
      walls.H.multipliers(set, left, normal);
      walls.H.apply(-1, normal, left);
      CHECK(test::largest(left) < 1e-9 * test::largest(q));
    }
  }
}

TEST_CASE("the full VI takes one obstacle per node", "[contact]") {
  const Walls walls(half_space("left", "[-0.1, 0]", "[1, 0]") + half_space("bottom", "[0, -0.2]", "[0, 1]"));
  CHECK_THROWS_WITH(walls.solver(scene::LinearMethod::direct, scene::ViMethod::full),
                    ContainsSubstring("2 obstacles") && ContainsSubstring("(0, 0, 0)") &&
                        ContainsSubstring("condensed"));
}

TEST_CASE("obstacles that leave no room are refused, at the start and on the way", "[contact]") {
  CHECK_THROWS_WITH(
      Walls(half_space("left", "[0.1, 0]", "[1, 0]") + half_space("left", "[0.05, 0]", "[-1, 0]")),
      ContainsSubstring("no room") && ContainsSubstring("t = 0 s"));
  const Walls walls(half_space("left", "[-0.1, 0]", "[1, 0]") +
                    half_space("left", "[\"0.1 - t\", 0]", "[-1, 0]"));
  contact::ContactPairs::Gaps gaps = walls.pairs.gaps();
  CHECK_NOTHROW(walls.pairs.psi(0.19, gaps));
  CHECK_THROWS_WITH(walls.pairs.psi(0.21, gaps),
                    ContainsSubstring("no room") && ContainsSubstring("t = 0.21 s"));
}

TEST_CASE("gaps follow obstacles that move, and others stay", "[contact]") {
  const Walls walls(half_space("left", "[-0.1, 0]", "[1, 0]") +
                    half_space("bottom", "[0, \"-0.2 + 0.5*t\"]", "[0, 1]"));
  const std::vector<double> start(walls.pairs.psi().begin(), walls.pairs.psi().end());
  contact::ContactPairs::Gaps gaps = walls.pairs.gaps();
  const std::span<const double> later = walls.pairs.psi(0.1, gaps);
  for (std::size_t i = 0; i < later.size(); ++i)
    CHECK(std::abs(later[i] - start[i] + (walls.pairs.obstacles()[i] == 1 ? 0.05 : 0)) < 1e-15);
  const Walls still(half_space("left", "[-0.1, 0]", "[1, 0]"));
  gaps = still.pairs.gaps();
  CHECK(still.pairs.psi(7, gaps).data() == still.pairs.psi().data());
}

TEST_CASE("nodes that start inside are moved out the shortest way if asked", "[contact]") {
  const auto project = [](const std::string& on, const std::string& point, const std::string& normal) {
    return half_space(on, point, normal, ", initial = \"project\"");
  };
  {
    // A plane over the bottom: its nodes go up along the normal, all others stay.
    const Walls walls(project("boundary", "[0, 0.1]", "[0.75, 1]"));
    petsc::Vector y = walls.space.vector(), exact = walls.space.vector();
    contact::place_outside(walls.pairs, y);
    walls.space.interpolate(
        scene::Field({"0.6*max(0, 0.08 - 0.6*x - 0.8*y)", "0.8*max(0, 0.08 - 0.6*x - 0.8*y)"}, "test", false),
        0, exact);
    CHECK(test::largest(exact) > 0.05);
    CHECK(test::difference(y, exact) < 1e-15);
  }
  {
    // In a corner of 45 degrees the closest place is on the edge where each alone would leave the other's
    // node inside.
    const Walls walls(project("left", "[0.1, 0]", "[1, 0]") + project("bottom", "[0, 0.2]", "[-1, 1]") +
                      project("left", "[0.05, 0]", "[1, 0]"));
    petsc::Vector y = walls.space.vector();
    contact::place_outside(walls.pairs, y);
    std::vector<double> gap(static_cast<std::size_t>(walls.pairs.count()));
    walls.H.gap(walls.pairs.psi(), y, gap);
    CHECK(std::ranges::min(gap) > -1e-15);
    // The corner node goes to (0.1, 0.3), not to (0.1, 0.2) as one after the other would.
    std::vector<double> normal(gap.size());
    walls.H.apply_transpose(y, normal);
    CHECK(walls.pairs.obstacles()[0] == 0);
    CHECK(std::abs(normal[0] + 0.1) < 1e-15);
    CHECK(std::abs(normal[1] + (0.3 - 0.1) / std::numbers::sqrt2) < 1e-15);
  }
  {
    // Only the contact that asks for it.
    const Walls walls(project("left", "[0.1, 0]", "[1, 0]") + half_space("bottom", "[0, 0.2]", "[0, 1]"));
    petsc::Vector y = walls.space.vector();
    CHECK_THROWS_WITH(contact::place_outside(walls.pairs, y),
                      ContainsSubstring("contact[1]: ") && ContainsSubstring("0.2 m inside"));
  }
  {
    const Walls walls(
        "{ on = \"boundary\", initial = \"project\", obstacle = { shape = \"ball\", center = [-0.2, -0.1, "
        "-0.3], radius = 0.5 } }",
        "cube.toml");
    petsc::Vector y = walls.space.vector(), exact = walls.space.vector();
    contact::place_outside(walls.pairs, y);
    const std::string out = "max(0, 0.5/sqrt((x + 0.2)^2 + (y + 0.1)^2 + (z + 0.3)^2) - 1)";
    walls.space.interpolate(
        scene::Field({"(x + 0.2)*" + out, "(y + 0.1)*" + out, "(z + 0.3)*" + out}, "test", false), 0, exact);
    CHECK(test::largest(exact) > 0.05);
    CHECK(test::difference(y, exact) < 1e-15);
  }
}

TEST_CASE("a candidate whose twin carries the force is not weak", "[contact]") {
  const std::string floor = half_space("bottom", "[0, 0]", "[0, 1]");
  for (const auto& [linear, solves] : {std::pair{scene::LinearMethod::direct, 0.0},
                                       {scene::LinearMethod::iterative, 0.0},
                                       {scene::LinearMethod::iterative, 1e9}}) {
    const Walls walls(floor + floor, "block.toml", {"time.step=1e-4"});
    const step::SolverChoice solver = walls.solver(linear, scene::ViMethod::condensed, solves);
    REQUIRE(walls.pairs.rows().dependent());
    contact::ContactState state(walls.pairs.count());
    // Pressed down, all are held, each with a share that is any; without weight each could be lifted.
    const petsc::Vector down = walls.pushing({"0", "-1"});
    (void)walls.solve(solver, down, state);
    CHECK(state.count(contact::Status::strong) == walls.pairs.count());
    check(VecZeroEntries(down));
    (void)walls.solve(solver, down, state);
    CHECK(state.count(contact::Status::weak) == walls.pairs.count());
    // One end is pressed down, the other touches.
    const petsc::Vector tilted = walls.pushing({"0", "max(0.5 - x, 0)*(0 - 1)"});
    (void)walls.solve(solver, tilted, state);
    const std::vector<double>& x = walls.pairs.points();
    for (std::size_t i = 0; i < state.status.size(); i += 2) {
      INFO(scene::name(linear) << ", at " << x[3 * i]);
      CHECK(state.status[i] == state.status[i + 1]);
    }
    CHECK(state.count(contact::Status::strong) > 0);
    CHECK(state.count(contact::Status::strong) < walls.pairs.count());
  }
}

TEST_CASE("the obstacles of a node follow each other in their order, at many nodes too", "[contact]") {
  const Walls walls(half_space("bottom", "[0, -0.1]", "[0, 1]") +
                        half_space("bottom", "[0, -0.2]", "[0.1, 1]") +
                        half_space("bottom", "[0, -0.3]", "[0.2, 1]"),
                    "block.toml", {"mesh.size=0.02"});
  const contact::ContactPairs& pairs = walls.pairs;
  REQUIRE(pairs.count() == 3 * 51);
  for (int i = 0; i < pairs.count(); ++i) {
    const auto j = static_cast<std::size_t>(i);
    CHECK(pairs.obstacles()[j] == i % 3);
    CHECK(pairs.rows().clusters()[j / 3].first == i / 3 * 3);
    CHECK(std::abs(pairs.points()[3 * j] - 0.02 * (i / 3)) < 1e-10);
  }
}

TEST_CASE("a node that clamps hold wholly is no candidate and needs no plane", "[contact]") {
  // At the corner (0, 0) the level set has the gradient of the expression is zero.
  const std::string nowhere =
      "{ on = \"boundary\", obstacle = { shape = \"signed-distance\", distance = \"x^2 + y^2 + "
      "0.01\" } },";
  CHECK_THROWS_WITH(Walls(nowhere), ContainsSubstring("the gradient of the expression is zero") &&
                                        ContainsSubstring("(0, 0, 0)"));
  const Walls walls(nowhere, "block.toml", {"clamp=[{on=\"bottom\"}]"});
  CHECK(walls.pairs.count() == 16 - 5);
  for (int i = 0; i < walls.pairs.count(); ++i)
    CHECK(walls.pairs.points()[3 * static_cast<std::size_t>(i) + 1] > 0.2);
}

TEST_CASE("a pair's direction is that of the touch of an obstacle that moves", "[contact]") {
  const auto round = [](const std::string& center) {
    return "{ on = \"bottom\", obstacle = { shape = \"ball\", radius = 1, center = " + center + " } },";
  };
  const int file = GENERATE(0, 1); // the ball comes from below, or passes by
  CAPTURE(file);
  const Walls walls(round(file == 0 ? "[0.5, \"-1.5 + 2*t\"]" : "[\"-1 + 4*t\", -1.1]"));
  const std::vector<double>&x = walls.pairs.points(), &nu = walls.pairs.normals();
  contact::ContactPairs::Gaps gaps = walls.pairs.gaps();
  REQUIRE(walls.pairs.count() == 5);
  REQUIRE(walls.pairs.moving());
  for (int i = 0; i < walls.pairs.count(); ++i) {
    const auto j = static_cast<std::size_t>(i);
    const double s = x[3 * j] - 0.5, across = file == 0 ? -s : 0;
    // A secant between two steps, 0.04 m apart; or the nearest step, 0.08 m from the next.
    CHECK(std::abs(nu[2 * j] - across) < (file == 0 ? 1e-4 : 0.04 / 1.1));
    CHECK(std::abs(std::hypot(nu[2 * j], nu[2 * j + 1]) - 1) < 1e-15);
    CHECK(nu[2 * j + 1] < 0);
  }
  for (const double t : {0.0, 0.25, 0.26, 0.6}) {
    const std::span<const double> psi = walls.pairs.psi(t, gaps);
    for (std::size_t j = 0; j < psi.size(); ++j)
      CHECK(std::abs(psi[j] -
                     (file == 0 ? std::hypot(x[3 * j] - 0.5, 1.5 - 2 * t)
                                : std::hypot(x[3 * j] + 1 - 4 * t, 1.1)) +
                     1) < 1e-15);
  }
  CHECK(std::ranges::equal(walls.pairs.psi(0, gaps), walls.pairs.psi()));
}
