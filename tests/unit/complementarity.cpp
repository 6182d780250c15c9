// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/lcp/complementarity.h"
#include "base/error.h"
#include "contact_parts.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/matchers/catch_matchers.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <fmt/format.h>

using namespace signorini;
using petsc::check;
using test::Parts;

TEST_CASE("touching without a force is weak contact", "[contact]") {
  const Parts parts;
  // The displacement that closes every gap exactly, held by its own load: g = 0, λ = 0.
  petsc::Vector y = parts.space.vector(), r = parts.space.vector(), solution = parts.space.vector();
  parts.space.interpolate(scene::Field({"0", "-0.1 - 0.3*x - y"}, "test", false), 0, y);
  check(MatMult(parts.D, y, r));
  const contact::ContactState state = parts.solve(r, solution);
  CHECK(state.count(contact::Status::weak) == parts.pairs.count());
  CHECK(static_cast<int>(state.active.size()) == parts.pairs.count());
}

TEST_CASE("what is negligible in contact knows no units and no time step", "[contact]") {
  // Steel on a plane. Its weight moves a node by gτ²/2 within the first step, by 2e-14 of its size where the
  // step is 2e-7 s: little beside the body, but all that happens.
  const std::vector<std::string> steel{"material.density=7800", "material.young=2e11",
                                       "contact.obstacle.point=[0, 0]", "contact.obstacle.normal=[0, 1]"};
  for (const char* solver : {"solver.vi=condensed", "solver.vi=full", "solver.linear=iterative"})
    for (const double tau : {1e-2, 1e-5, 2e-7, 1e-9}) {
      std::vector<std::string> overrides = steel;
      overrides.insert(overrides.end(),
                       {solver, fmt::format("time.step={}", tau), fmt::format("time.end={}", 3 * tau)});
      const Parts parts(overrides);
      const int m = parts.pairs.count();
      const fem::Operators body = fem::assemble_operators(parts.space, parts.scene.materials, true);
      petsc::Vector pull = parts.space.vector(), r = parts.space.vector(), y = parts.space.vector();
      for (const double g : {-10.0, 10.0}) {
        INFO(solver << ", a step of " << tau << " s, " << g << " m/s²");
        parts.space.interpolate(scene::Field({"0", fmt::format("{}", g)}, "test", false), 0, pull);
        check(MatMult(body.M, pull, r));
        check(VecScale(r, tau * tau / 2));
        check(VecZeroEntries(y));
        const contact::ContactState state = parts.solve(r, y);
        CHECK(state.count(contact::Status::strong) == (g < 0 ? m : 0));
        if (g > 0 && tau * tau * g / 2 >
                         1e-12) // else by less than the rounding of places, where it may count as closed
          CHECK(state.count(contact::Status::open) == m);
      }
      // At rest a force too small for the solution to show, as of rounding, is none.
      check(VecZeroEntries(y));
      check(VecZeroEntries(r));
      CHECK(parts.solve(r, y).count(contact::Status::weak) == m);
    }
}

TEST_CASE("weak contact is told from rounding in a body that has moved", "[contact]") {
  // Moved along the plane by its own length, with no weight and with one.
  for (const char* linear : {"direct", "iterative"})
    for (const char* young : {"50", "2e11"})
      for (const double tau : {2e-2, 1e-4, 1e-6}) {
        if (linear == std::string("iterative") && tau < 1e-4)
          continue; // the weight is below what conjugate gradients resolve of so large a motion
        INFO(linear << ", Young's modulus " << young << " Pa, a step of " << tau << " s");
        const Parts parts({fmt::format("time.step={}", tau), fmt::format("material.young={}", young),
                           "material.density=7800", fmt::format("solver.linear={}", linear),
                           "contact.obstacle.point=[0, 0]", "contact.obstacle.normal=[0, 1]"});
        const fem::Operators body = fem::assemble_operators(parts.space, parts.scene.materials, true);
        petsc::Vector away = parts.space.vector(), r = parts.space.vector(), y = parts.space.vector(),
                      pull = parts.space.vector();
        parts.space.interpolate(scene::Field({"1", "0"}, "test", false), 0, away);
        check(MatMult(body.M, away, r)); // A away = 0: a rigid motion
        check(VecCopy(away, y));
        CHECK(parts.solve(r, y).count(contact::Status::strong) == 0);
        parts.space.interpolate(scene::Field({"0", "-10"}, "test", false), 0, pull);
        check(VecScale(pull, tau * tau / 2));
        check(MatMultAdd(body.M, pull, r, r));
        check(VecCopy(away, y));
        CHECK(parts.solve(r, y).count(contact::Status::strong) == parts.pairs.count());
      }
}

TEST_CASE("a gap that is not closed is no contact", "[contact]") {
  const Parts parts({"contact.obstacle.point=[0, -1e-11]", "contact.obstacle.normal=[0, 1]"});
  petsc::Vector y = parts.space.vector(), r = parts.space.vector();
  CHECK(parts.solve(r, y).count(contact::Status::open) == parts.pairs.count());
}

TEST_CASE("units of mass and time leave contact as it is", "[contact]") {
  const Parts parts;
  const double unit = GENERATE(1e-9, 1e9);
  CAPTURE(unit);
  petsc::Matrix D = Parts::copy(parts.D);
  check(MatScale(D, unit));
  const step::SolverChoice solver(std::move(D), &parts.pairs, parts.scene.solver, true);
  const auto solve = [&](const contact::ContactState& expected, Vec r) {
    petsc::Vector scaled = petsc::copy(r), y = parts.space.vector();
    check(VecScale(scaled, unit));
    contact::ContactState state(parts.pairs.count());
    contact::Workspace work = solver.contact()->workspace();
    const contact::ActiveSet none;
    const contact::ContactProblem step{scaled, parts.pairs.psi(), none, state, y};
    solver.contact()->solve(step, work);
    CHECK(state.status == expected.status);
  };
  petsc::Vector y = parts.space.vector(), r = parts.space.vector();
  for (int which = 0; which < 3; ++which)
    solve(parts.solve(parts.pressing(which), y), parts.pressing(which));
  parts.space.interpolate(scene::Field({"0", "-0.1 - 0.3*x - y"}, "test", false), 0, y);
  check(MatMult(parts.D, y, r));
  solve(parts.solve(r, y), r);
}

TEST_CASE("contact is told apart by what rounding leaves of gaps, and of forces by the motion they make",
          "[contact]") {
  const Parts parts;
  const contact::Complementarity complementarity(parts.H, parts.pairs.diameter(), fem::diagonal(parts.D));
  const auto m = static_cast<std::size_t>(parts.pairs.count());
  const petsc::Vector diagonal = fem::diagonal(parts.D), still = parts.space.vector();
  std::vector<double> stiffness(m); // against moving a node alone
  for (std::size_t i = 0; i < m; ++i) {
    std::vector<double> one(m);
    one[i] = 1;
    petsc::Vector normal = parts.space.vector(), product = parts.space.vector();
    parts.H.apply(1, one, normal);
    check(VecPointwiseMult(product, diagonal, normal));
    stiffness[i] = petsc::dot(product, normal);
    REQUIRE(stiffness[i] > 0);
  }
  const double allowed = parts.pairs.gap_tolerance(), deep = 0.01;
  // A force (by the motion that it makes) and a gap at one candidate, where the others are clearly open or
  // pressed.
  const auto state = [&](std::size_t i, double motion, double gap) {
    contact::ContactState s(parts.pairs.count());
    for (std::size_t j = 0; j < m; ++j)
      (j % 2 ? s.lambda[j] : s.gap[j]) = deep * (j % 2 ? stiffness[j] : 1);
    s.lambda[i] = motion * stiffness[i];
    s.gap[i] = gap;
    return s;
  };
  // 1e-10 of the largest force is nothing, gaps are known to rounding beside the body. An odd candidate's
  // neighbours are the pressed ones.
  const double motion = 1e-10 * deep,
               closed = 1e3 * std::numeric_limits<double>::epsilon() * parts.pairs.diameter();
  for (std::size_t i = 0; i < m; ++i) {
    for (const auto& [forces, gap, status] : {std::tuple{0.5, 0.5 * closed, contact::Status::weak},
                                              {-0.5, -0.5 * allowed, contact::Status::weak},
                                              {0.5, 2 * closed, contact::Status::open},
                                              {-0.5, 2 * allowed, contact::Status::open},
                                              {2.0, 0.5 * allowed, contact::Status::strong},
                                              {2.0, -0.5 * allowed, contact::Status::strong}}) {
      CAPTURE(forces, gap, status);
      contact::ContactState s = state(i, forces * motion, gap);
      CHECK(complementarity.holds(s, allowed, 0));
      s.active = {4, 3};
      complementarity.classify(s, still);
      contact::ActiveSet expected;
      for (std::size_t j = 0; j < m; ++j) {
        const contact::Status of_j = j == i  ? status
                                     : j % 2 ? contact::Status::strong
                                             : contact::Status::open;
        CHECK(s.status[j] == of_j);
        if (of_j != contact::Status::open)
          expected.push_back(static_cast<int>(j));
      }
      CHECK(s.active == expected);
    }
    for (const auto& [forces, gaps] :
         {std::pair{0.0, -2.0}, {-2.0, 0.0}, {2.0, 2.0}, {2.0, -2.0}, {-2.0, 2.0}}) {
      const contact::ContactState by_motion = state(i, forces * motion, gaps * allowed),
                                  by_gap = state(i, forces * allowed, gaps * allowed);
      CHECK_FALSE(complementarity.holds(by_motion, allowed, 0));
      CHECK_FALSE(complementarity.holds_within(allowed, by_gap));
      CHECK(complementarity.holds_within(3 * allowed, by_gap));
      contact::ContactState s = by_motion;
      CHECK_THROWS_AS(complementarity.classify(s, still), SolverFailure);
    }
    contact::ContactState inside = state(i, 0, -0.1);
    CHECK_THROWS_WITH(complementarity.classify(inside, still),
                      Catch::Matchers::ContainsSubstring("largest penetration is 1.000e-01 m"));
    for (const auto& [force, gap] : {std::pair{NAN, 0.0}, {0.0, NAN}, {INFINITY, 0.0}, {0.0, INFINITY}}) {
      CAPTURE(force, gap);
      contact::ContactState s = state(i, force, gap);
      CHECK_THROWS_AS(complementarity.classify(s, still), SolverFailure);
    }
  }
}
