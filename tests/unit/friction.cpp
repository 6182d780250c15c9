// SPDX-License-Identifier: GPL-3.0-or-later
// Friction: its laws in motions, and one-sided derivatives where candidates may open, slip or stick.
#include "contact/friction.h"
#include "base/error.h"
#include "body.h"
#include "contact/solver/condensed.h"
#include "contact_parts.h"
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators_all.hpp>
#include <fmt/format.h>
#include <random>

using namespace signorini;
using contact::Motion, contact::Status;
using petsc::check;
using test::Parts;

namespace {

constexpr double mu = 0.5;

/// Each scheme, as settings.
const std::vector<std::vector<std::string>> schemes{
    {"time.scheme=contact-implicit"},
    {"time.scheme=contact-stabilized"},
    {"contact.mass=massless"},
    {"time.scheme=contact-stabilized", "contact.mass=massless-tangential"}};

std::vector<std::string> with(std::vector<std::string> all, const std::vector<std::string>& more) {
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

/// A contact step whose solution was chosen: multipliers, gaps, displacements.
struct Chosen {
  Parts parts;
  std::vector<double> psi, rho, gap;
  petsc::Vector r = parts.space.vector();
  contact::Workspace work;

  double friction = mu;

  explicit Chosen(const char* file, const std::string& law = "contact.friction=0.5")
      : parts({law}, 0, file), psi(static_cast<std::size_t>(parts.H.count())), rho(psi.size()),
        gap(psi.size()), work(parts.solver.contact()->workspace()) {}

  /// Sets a candidate: λ, normal gap, |σ| and slip along the direction of `angle`.
  void set(int i, double lambda, double g, double sigma, double slip, double angle) {
    const contact::ConstraintRows& H = parts.H;
    rho[H.row(i, 0)] = lambda;
    gap[H.row(i, 0)] = g;
    const std::array<double, 2> d = H.size(i) == 2 ? std::array{angle > 0 ? 1.0 : -1.0, 0.0}
                                                   : std::array{std::cos(angle), std::sin(angle)};
    for (std::size_t c = 1; c < H.size(i); ++c) {
      rho[H.row(i, c)] = sigma * d[c - 1];
      gap[H.row(i, c)] = -slip * d[c - 1];
    }
  }

  /// Sets r and ψ so that the step has this solution with the displacement y.
  void finish(Vec y) {
    check(MatMult(parts.D, y, r));
    parts.H.apply(1, rho, r);
    parts.H.apply_transpose(y, psi);
    for (std::size_t i = 0; i < psi.size(); ++i)
      psi[i] += gap[i];
  }

  contact::ContactState solve(Vec force, std::span<const double> gaps, Vec y) {
    contact::ContactState state(parts.H.groups(), parts.H.count());
    state.friction.assign(static_cast<std::size_t>(parts.H.groups()), friction);
    const contact::ActiveSet previous{};
    parts.solver.contact()->solve({force, gaps, previous, state, y}, work);
    return state;
  }

  /// The step beside the chosen one, and the piece of the one-sided derivative towards it.
  struct Beside {
    contact::ContactState state;
    contact::ContactLinearisation piece;
  };
  /// Compares the one-sided derivative at the solution `at`, y in one of forty directions with a difference,
  /// and with the two-sided derivative on the chosen piece.
  Beside compare(int which, const contact::ContactState& at, Vec y) {
    const bool space = parts.space.dim() == 3;
    petsc::Vector change = parts.pressing(which), x = parts.space.vector(), z = petsc::copy(y);
    check(VecScale(change, which % 2 ? 0.1 : -0.1));
    constexpr double epsilon = 1e-6;
    petsc::Vector moved = petsc::copy(r);
    check(VecAXPY(moved, epsilon, change));
    Beside found{solve(moved, psi, z), at.linearisation()};
    check(VecAXPBY(z, -1 / epsilon, 1 / epsilon, y));
    contact::ContactLinearisation& one = found.piece;
    const contact::ActiveSet set = one.active;
    const std::vector<double> zero(psi.size());
    parts.solver.contact()->solve_one_sided({.r = change, .set = set, .value = zero, .x = x}, one, work);
    const double first_order = space ? 1e3 * epsilon : 1e-8;
    CHECK(test::difference(z, x) < first_order * test::largest(x));
    // Where the difference is open, slips or sticks, the derivative does.
    CHECK(one.active == found.state.active);
    for (std::size_t j = 0; j < one.active.size() && one.active == found.state.active; ++j) {
      CHECK(one.motion(j) == found.state.motion(j));
      CHECK(one.closed(j) == found.state.closed(j));
    }
    petsc::Vector again = parts.space.vector();
    parts.solver.contact()->solve_linearised(
        {.r = change, .set = one.active, .equations = one.equations, .x = again}, work);
    CHECK(test::difference(again, x) < 1e-9 * test::largest(x));
    return found;
  }
};

} // namespace

TEST_CASE("one-sided derivatives where candidates may open, slip or stick", "[contact]") {
  const bool space = GENERATE(false, true);
  CAPTURE(space);
  Chosen step(space ? "tests/data/cube.toml" : "tests/data/block.toml");
  const contact::ConstraintRows& H = step.parts.H;
  const int m = H.groups();
  REQUIRE(m >= 5);
  petsc::Vector y = test::smooth(step.parts.space, 1), found = step.parts.space.vector();
  check(VecScale(y, 0.01));
  // A unit of the multipliers that moves nodes by about 0.01 m.
  std::vector<double> stiffness = H.weighted_squares(fem::diagonal(step.parts.D));
  const double unit = 0.01 * stiffness.front();
  for (int i = 0; i < m; ++i)
    step.set(i, 0, 0.05, 0, 0, 1);
  step.set(0, unit, 0, 0.2 * mu * unit, 0, 0.4); // sticks
  step.set(1, unit, 0, mu * unit, 0.01, -2.0);   // slips
  step.set(2, 0, 0, 0, 0.01, 1.2);               // opens or slips
  step.set(3, 0, 0, 0, 0, 1);                    // opens, slips or sticks
  step.set(4, unit, 0, mu * unit, 0, 2.5);       // slips or sticks
  step.finish(y);
  const contact::ContactState at = step.solve(step.r, step.psi, found);
  REQUIRE(test::difference(y, found) < 1e-11 * test::largest(y));
  CHECK(at.weak == contact::ActiveSet{2, 3, 4});
  CHECK(at.motions()[0] == Motion::sticks);
  CHECK(at.motions()[1] == Motion::slips);

  int opened = 0, closed = 0, slipped = 0, stuck = 0;
  for (int which = 0; which < 40; ++which) {
    const contact::ContactLinearisation one = step.compare(which, at, found).piece;
    for (const int i : {2, 3}) {
      const bool is_closed = std::ranges::binary_search(one.active, i);
      (is_closed ? closed : opened) += 1;
    }
    for (std::size_t j = 0; j < one.active.size(); ++j)
      if (one.active[j] == 3 || one.active[j] == 4)
        (one.equations[j].motion == Motion::slips ? slipped : stuck) += 1;
  }
  CHECK(opened > 5);
  CHECK(closed > 5);
  CHECK(slipped > 5);
  CHECK(stuck > 5);
}

TEST_CASE("Tresca friction: one-sided derivatives where candidates may open, and may slip", "[contact]") {
  const bool space = GENERATE(false, true);
  CAPTURE(space);
  Chosen step(space ? "tests/data/cube.toml" : "tests/data/block.toml", "contact.friction={bound=1}");
  const contact::ConstraintRows& H = step.parts.H;
  const int m = H.groups();
  REQUIRE(m >= 5);
  petsc::Vector y = test::smooth(step.parts.space, 1), found = step.parts.space.vector();
  check(VecScale(y, 0.01));
  const double unit = 0.01 * H.weighted_squares(fem::diagonal(step.parts.D)).front(), s = mu * unit;
  step.friction = s;
  for (int i = 0; i < m; ++i)
    step.set(i, 0, 0.05, 0, 0, 1);     // open, sticks
  step.set(0, 0, 0.05, s, 0.01, -2.0); // open, slips
  step.set(1, 0, 0, s, 0.01, 1.2);     // opens or closes, slips
  step.set(2, 0, 0, s, 0, 1);          // opens or closes, slips or sticks
  step.set(3, unit, 0, s, 0, 2.5);     // closed, slips or sticks
  step.set(4, 0, 0.05, s, 0, 0.3);     // open, slips or sticks
  step.finish(y);
  const contact::ContactState at = step.solve(step.r, step.psi, found);
  REQUIRE(test::difference(y, found) < 1e-11 * test::largest(y));
  CHECK(at.weak == contact::ActiveSet{1, 2, 3, 4});
  REQUIRE(at.active.size() == static_cast<std::size_t>(m));
  CHECK(at.contact::ContactLinearisation::closed_set() == contact::ActiveSet{1, 2, 3});
  CHECK(at.motion(0) == Motion::slips);

  int opened = 0, closed = 0, slipped = 0, stuck = 0;
  for (int which = 0; which < 40; ++which) {
    const auto [other, one] = step.compare(which, at, found);
    REQUIRE(one.active == other.active);
    for (const std::size_t j : {1, 2})
      (one.closed(j) ? closed : opened) += 1;
    for (const std::size_t j : {2, 3, 4})
      (one.motion(j) == Motion::slips ? slipped : stuck) += 1;
  }
  CHECK(opened > 5);
  CHECK(closed > 5);
  CHECK(slipped > 5);
  CHECK(stuck > 5);
}

TEST_CASE("friction keeps the laws of energy and momentum, and no bounce gains energy", "[forward]") {
  const std::vector<std::string> scheme = GENERATE(from_range(schemes));
  const auto [file, degree, bounces] =
      GENERATE(std::tuple("tests/data/block.toml", 1, 170), std::tuple("tests/data/block.toml", 2, 40),
               std::tuple("tests/data/cube.toml", 1, 40));
  CAPTURE(scheme, file, degree);
  const bool space = std::string(file) == "tests/data/cube.toml";
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int slips = 0, sticks = 0, free = 0, tangled = 0;
  for (int bounce = 0; bounce < bounces; ++bounce) {
    const double friction = 0.1 * std::pow(20, (uniform(generator) + 1) / 2);
    const double across = 2 * uniform(generator), speed = 0.5 + std::abs(uniform(generator));
    const std::string belt = fmt::format("{}", uniform(generator));
    // every tenth bounce with a bound, of about the tractions of the impact
    std::vector<std::string> settings =
        with(scheme, {fmt::format("mesh.degree={}", degree),
                      bounce % 10 == 9 ? fmt::format("contact.friction={{bound={}}}", friction)
                                       : fmt::format("contact.friction={}", friction)});
    settings.push_back(space ? fmt::format("initial.velocity=[\"{}\", \"0.3\", \"-{}\"]", across, speed)
                             : fmt::format("initial.velocity=[\"{}\", \"-{}\"]", across, speed));
    if (bounce % 2)
      settings.push_back("contact.obstacle.surface_velocity=" +
                         (space ? "[\"" + belt + "\", \"0.2\", \"0\"]" : "[\"" + belt + "\", \"0\"]"));
    const test::Ready ready(file, settings);
    const test::Recorded motion(ready.problem, ready.problem.load());
    const test::Laws laws(motion);
    CHECK(laws.energy < 1e-12);
    CHECK(laws.momentum < 1e-12);
    double most = 0;
    for (const diagnostics::StepBalance& step : motion.balance)
      most = std::max(most, step.energy());
    for (std::size_t k = 1; k < motion.balance.size(); ++k) {
      const diagnostics::StepBalance& step = motion.balance[k];
      CHECK(step.contact_work - step.belt_work <= 1e-13 * most);
      CHECK(step.friction_work <= 1e-13 * most);
      CHECK((bounce % 2 || step.belt_work == 0));
      slips += motion.contact[k].count(Motion::slips);
      sticks += motion.contact[k].count(Motion::sticks);
      free += motion.contact[k].closed_set().empty();
      tangled += step.contact_work > 0;
    }
  }
  CHECK(slips > bounces);
  CHECK(sticks > bounces);
  CHECK(free > bounces);
  CHECK(tangled > 0); // belts do work
}

TEST_CASE("coefficients of friction and surface velocities vary in space and time", "[contact]") {
  const test::Body body("tests/data/block.toml", 1,
                        {"contact.friction=\"0.1 + x + t\"", "contact.obstacle.normal=[0, 1]",
                         "contact.obstacle.point=[\"3*t\", -0.1]",
                         "contact.obstacle.surface_velocity=[\"x*t\", \"7\"]"});
  const fem::DirichletDofs clamped(body.space, {});
  const contact::ContactPairs pairs(body.space, clamped, body.scene.contacts);
  std::vector<double> friction;
  pairs.friction(0.5, 1, friction);
  std::vector<double> way(static_cast<std::size_t>(pairs.rows().count()));
  pairs.obstacle_ways(0.2, 0.4, way);
  REQUIRE(pairs.count() > 3);
  for (int i = 0; i < pairs.count(); ++i) {
    const double x = pairs.points()[3 * static_cast<std::size_t>(i)];
    REQUIRE(pairs.rows().size(i) == 2);
    const std::size_t row = pairs.rows().row(i, 1);
    CHECK(friction[static_cast<std::size_t>(i)] == Catch::Approx(0.6 + x));
    CHECK(way[static_cast<std::size_t>(i)] == 0);
    // along the tangent, by the motion of the plane's point and by the belt at the middle of the step
    CHECK(way[row] == Catch::Approx(pairs.rows().motion(static_cast<int>(row))[0] * (0.6 + 0.2 * 0.3 * x)));
  }
}

TEST_CASE("bounds of friction are tractions times areas, of midpoints too", "[contact]") {
  const int degree = GENERATE(1, 2);
  CAPTURE(degree);
  const test::Body body("tests/data/block.toml", degree, {"contact.friction={bound=\"2 + t\"}"});
  const contact::ContactPairs pairs(body.space, fem::DirichletDofs(body.space, {}), body.scene.contacts);
  std::vector<double> friction;
  constexpr double impulse = 0.1;
  pairs.friction(1, impulse, friction);
  REQUIRE(friction.size() > 4);
  double sum = 0, least = 1;
  for (const double bound : friction) {
    sum += bound;
    least = std::min(least, bound);
  }
  CHECK(sum == Catch::Approx(3 * impulse)); // of the unit square's lower side
  // hat functions of a quarter: 1/8 at the ends; of degree 2 they have a sixth of an edge
  CHECK(least == Catch::Approx(3 * impulse * (degree == 1 ? 0.125 : 0.25 / 6)));
}

TEST_CASE("tangents that clamps hold have no friction, and those held in part are refused", "[contact]") {
  const test::Body body("tests/data/block.toml", 1,
                        {"contact.friction=0.3", "contact.obstacle.normal=[0, 1]",
                         "clamp=[{on=\"bottom\", components=[\"x\"]}]"});
  const fem::DirichletDofs clamped(body.space, body.scene.clamps);
  const contact::ContactPairs pairs(body.space, clamped, body.scene.contacts);
  CHECK(pairs.rows().count() == pairs.count());
  const test::Body tilted("tests/data/block.toml", 1,
                          {"contact.friction=0.3", "clamp=[{on=\"bottom\", components=[\"x\"]}]"});
  CHECK_THROWS_AS(contact::ContactPairs(tilted.space, fem::DirichletDofs(tilted.space, tilted.scene.clamps),
                                        tilted.scene.contacts),
                  UserError);
}

TEST_CASE("friction that is zero at places and times obeys the laws", "[forward]") {
  const std::vector<std::string> scheme = GENERATE(from_range(schemes));
  const std::string friction =
      GENERATE(as<std::string>{}, "\"0*t\"", "\"t < 0.3 ? 0 : 0.4\"", "\"x < 0.5 ? 0 : 0.3\"", "1e-14",
               "{bound=0}", "{bound=\"x < 0.5 ? 0 : 0.3\"}");
  const bool space = GENERATE(false, true);
  CAPTURE(scheme, friction, space);
  const test::Ready ready(space ? "tests/data/cube.toml" : "tests/data/block.toml",
                          with(scheme, {"contact.friction=" + friction}));
  const test::Recorded motion(ready.problem, ready.problem.load());
  const test::Laws laws(motion);
  CHECK(laws.touched > 5);
  CHECK(laws.energy < 1e-12);
  CHECK(laws.momentum < 1e-12);
}

TEST_CASE("friction is refused beside nodes whose constraints depend on each other", "[contact]") {
  const std::string corner =
      "contact=[{on=\"bottom\", obstacle={shape=\"half-space\", point=[0, -0.1], normal=[0, 1]}}, "
      "{on=\"bottom\", obstacle={shape=\"half-space\", point=[0, -0.2], normal=[0, 1]}}";
  const auto pairs = [&](const std::string& third) {
    const test::Body body("tests/data/block.toml", 1, {corner + third + "]"});
    return contact::ContactPairs(body.space, fem::DirichletDofs(body.space, {}), body.scene.contacts).count();
  };
  const std::string top = ", {on=\"top\", obstacle={shape=\"half-space\", point=[0, 9], normal=[0, -1]}";
  CHECK(pairs(top + "}") > 0);
  CHECK_THROWS_AS(pairs(top + ", friction=0.2}"), UserError);
}

TEST_CASE("without tangential mass velocities are extrapolated, also from clamps that move", "[forward]") {
  const bool bounded = GENERATE(false, true);
  // A bound acts on the upper side too, where the boundary faces away from the obstacle.
  const test::Ready ready(
      "tests/data/block.toml",
      with(schemes.back(),
           {bounded ? "contact.friction={bound=0.2}" : "contact.friction=0.3",
            bounded ? "contact.on=top" : "contact.on=bottom",
            "clamp=[{on=\"left\", value=[\"0.1*sin(3*t)^2\", \"-0.1*t^2\"]}]", "initial={}"}));
  const step::Stepper& stepper = ready.problem.stepper;
  const petsc::Vector projected = ready.problem.space.vector();
  double moved = 0;
  trajectory::integrate(stepper, ready.problem.grid, ready.problem.initial, ready.problem.load(),
                        [&](const trajectory::Frame& frame) {
                          check(MatMult(stepper.velocity_extrapolation(), frame.after.v(), projected));
                          const double size = test::largest(frame.after.v());
                          CHECK(test::difference(projected, frame.after.v()) <= 1e-12 * size);
                          moved = std::max(moved, size);
                        });
  CHECK(moved > 0.1);
  // The rows of E that are not those of the identity belong to candidates.
  petsc::Vector one = ready.problem.space.vector();
  const auto rows = static_cast<std::size_t>(stepper.rows());
  std::vector<double> tangential(rows);
  tangential.back() = 1;
  stepper.pairs()->rows().apply(1, tangential, one);
  check(MatMult(stepper.velocity_extrapolation(), one, projected));
  CHECK(test::largest(one) > 0.1);
  CHECK(test::largest(projected) < 1e-14);
}
