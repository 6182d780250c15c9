// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/collective.h"
#include "base/error.h"
#include "base/timers.h"
#include "contact/pairs.h"
#include "contact/placement.h"
#include "contact/solver/condensed.h"
#include "contact_parts.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <fmt/format.h>
#include <regex>
#include <set>
#include <tuple>

using namespace signorini;
using petsc::check;
using test::Parts;

TEST_CASE("candidates know their gap to a tilted plane", "[contact]") {
  const Parts parts;
  const double n = std::hypot(0.3, 1.0);
  REQUIRE(parts.pairs.count() == 5);
  for (int i = 0; i < parts.pairs.count(); ++i) {
    const double* x = &parts.pairs.points()[static_cast<std::size_t>(3 * i)];
    CHECK(std::abs(x[0] - 0.25 * i) < 1e-10); // ordered by coordinates on any number of ranks
    CHECK(std::abs(parts.pairs.psi()[static_cast<std::size_t>(i)] - (0.3 * x[0] + x[1] + 0.1) / n) < 1e-14);
  }
  petsc::Vector y = parts.space.vector();
  check(VecSet(y, -0.05));
  std::vector<double> gap(5);
  parts.H.gap(parts.pairs.psi(), y, gap);
  for (int i = 0; i < 5; ++i)
    CHECK(std::abs(gap[static_cast<std::size_t>(i)] -
                   (parts.pairs.psi()[static_cast<std::size_t>(i)] - 0.05 * 1.3 / n)) < 1e-14);
  check(VecSet(y, -1));
  CHECK_THROWS_AS(contact::place_outside(parts.pairs, y), UserError);
}

namespace {
constexpr double many = 1e9; ///< solves, for which columns on demand pay
long& columns = count("columns on demand");
} // namespace

TEST_CASE("all solvers of the contact step find its solution, which is complementary", "[contact]") {
  for (const std::vector<std::string>& overrides :
       {std::vector<std::string>{},
        {"mesh.degree=2"},
        {"mesh.size=0.1", "contact.obstacle.normal=[-1, 0.4]", "contact.obstacle.point=[0.8, 0]",
         "contact.on=boundary"}}) {
    const auto with = [&](const char* option, double solves = 0) {
      std::vector<std::string> all = overrides;
      all.push_back(option);
      return Parts(all, solves);
    };
    const Parts parts = with("solver.vi=condensed"), full = with("solver.vi=full"),
                iterative = with("solver.linear=iterative"),
                on_demand = with("solver.linear=iterative", many);
    CHECK(iterative.solver.choice().find("on demand") == std::string::npos);
    CHECK(on_demand.solver.choice().find("on demand") != std::string::npos);
    const long before = columns;
    std::set<int> ever;
    int closed = 0, open = 0;
    for (int which = 0; which < 6; ++which) {
      const petsc::Vector r = parts.pressing(which);
      petsc::Vector y = parts.space.vector(), z = parts.space.vector(), x = parts.space.vector(),
                    w = parts.space.vector(), defect = parts.space.vector();
      const contact::ContactState a = parts.solve(r, y), b = full.solve(r, z), c = iterative.solve(r, x),
                                  d = on_demand.solve(r, w);
      CHECK(a.active == b.active);
      CHECK(a.active == c.active);
      CHECK(a.active == d.active);
      CHECK(test::difference(y, z) < 1e-12 * test::largest(y));
      CHECK(test::difference(y, x) < 1e-10 * test::largest(y));
      CHECK(test::difference(y, w) < 1e-10 * test::largest(y));
      ever.insert(a.active.begin(), a.active.end());
      closed += a.count(contact::Status::strong);
      open += a.count(contact::Status::open);
      // D y = r − Nλ with 0 ≤ λ ⟂ g ≥ 0.
      check(MatMult(parts.D, y, defect));
      check(VecAXPY(defect, -1, r));
      parts.H.apply(1, a.lambda, defect);
      CHECK(test::largest(defect) < 1e-13 * test::largest(r));
      for (std::size_t i = 0; i < a.lambda.size(); ++i) {
        CHECK(a.lambda[i] >= 0);
        CHECK(a.gap[i] >= -1e-14);
        CHECK(std::abs(a.lambda[i] * a.gap[i]) < 1e-14);
      }
    }
    CHECK(closed > 0);
    CHECK(open > 0);
    // One solve for each candidate that closes, or does in a set on the way.
    CHECK(columns - before >= static_cast<long>(ever.size()));
    CHECK(columns - before <= parts.pairs.count());
    // Where a column takes as many solves as it saves, none is made.
    CHECK(with("solver.linear=iterative", 10).solver.choice().find("on demand") == std::string::npos);
  }
}

TEST_CASE("a warm start changes the effort, not the solution", "[contact]") {
  const Parts parts({"mesh.size=0.1"});
  const petsc::Vector r = parts.pressing(2);
  petsc::Vector cold = parts.space.vector(), warm = parts.space.vector();
  const contact::ContactState first = parts.solve(r, cold);
  REQUIRE(first.count(contact::Status::strong) > 1);
  CHECK(first.vi_iterations > 0);
  CHECK(parts.solve(r, first, warm).vi_iterations == 0);
  CHECK(test::difference(cold, warm) < 1e-14 * test::largest(cold)); // MUMPS sums in no fixed order
}

TEST_CASE("a step that is long beside a fall through the body is refined from its residual", "[contact]") {
  const Parts parts({"time={end=1e4, step=1e4}", "contact.obstacle.normal=[1, 1]"});
  const contact::ConstraintRows& H = parts.H;
  const auto eliminated = [&](const MumpsSolver& factor) {
    return std::make_unique<contact::StoredColumnsCondensation>(H, factor, parts.space.vector(), 1e9);
  };
  MumpsSolver factor(parts.D);
  factor.factorise();
  int passes = 0;
  const contact::Residual residual = [&](Vec y, Vec r, Vec out) {
    check(MatMult(parts.D, y, out));
    check(VecAYPX(out, -1, r));
    ++passes;
  };
  const contact::CondensedSolver plain(H, parts.pairs.diameter(), fem::diagonal(parts.D), eliminated(factor),
                                       {}),
      refined(H, parts.pairs.diameter(), fem::diagonal(parts.D), eliminated(factor), residual);
  petsc::Vector fallen = test::smooth(parts.space, 1), r = parts.space.vector();
  constexpr double fall = 1e8; // m: its rounding is a hundred negligible gaps
  check(VecShift(fallen, -fall));
  check(MatMult(parts.D, fallen, r));
  PetscReal norm = 0;
  check(MatNorm(parts.D, NORM_INFINITY, &norm));
  const contact::ActiveSet previous;
  const auto off = [&](const contact::CondensedSolver& solver) {
    petsc::Vector y = parts.space.vector(), defect = parts.space.vector();
    contact::ContactState state(parts.pairs.count());
    contact::Workspace work = solver.workspace();
    const contact::ContactProblem step{r, parts.pairs.psi(), previous, state, y};
    solver.solve(step, work);
    REQUIRE(!state.active.empty());
    CHECK(test::largest(y) < 1e-5 * fall);
    check(MatMult(parts.D, y, defect));
    check(VecAXPY(defect, -1, r));
    H.apply(1, state.lambda, defect);
    std::vector<double> gap(state.gap.size());
    H.gap(parts.pairs.psi(), y, gap);
    double penetration = 0;
    for (const int i : state.active)
      penetration = std::max(penetration, std::abs(gap[static_cast<std::size_t>(i)]));
    return std::pair{test::largest(defect) / (norm * test::largest(y)), penetration / test::largest(y)};
  };
  CHECK_THROWS_AS(off(plain), SolverFailure);
  const auto [defect, gap] = off(refined);
  CHECK(passes > 0);
  CHECK(defect < 1e-14);
  CHECK(gap < 1e-14);
}

TEST_CASE("linearised steps move along the obstacle with normal forces alone", "[contact]") {
  for (const auto& [linear, tolerance, solves] :
       {std::tuple{"direct", 1e-13, 0.0}, {"iterative", 1e-10, 0.0}, {"iterative", 1e-10, many}}) {
    const Parts parts({"mesh.degree=2", fmt::format("solver.linear={}", linear)}, solves);
    const contact::ActiveSet set{1, 2, 5};
    const petsc::Vector r = parts.pressing(3);
    petsc::Vector p = parts.space.vector(), defect = parts.space.vector();
    contact::Workspace work = parts.solver.contact()->workspace();
    const contact::LinearisedContact step{.r = r, .set = set, .x = p};
    parts.solver.contact()->solve_linearised(step, work);
    std::vector<double> normal(static_cast<std::size_t>(parts.pairs.count()));
    parts.H.apply_transpose(p, normal);
    for (int i : set)
      CHECK(std::abs(normal[static_cast<std::size_t>(i)]) < 1e-13 * test::largest(p));
    // What is left of r − D p must be normal forces on the set.
    check(MatMult(parts.D, p, defect));
    check(VecAYPX(defect, -1, r));
    parts.H.apply_transpose(defect, normal);
    for (std::size_t i = 0; i < normal.size(); ++i)
      if (std::ranges::find(set, static_cast<int>(i)) == set.end())
        normal[i] = 0;
    CHECK(test::largest(defect) > 1e-3 * test::largest(r));
    parts.H.apply(-1, normal, defect);
    CHECK(test::largest(defect) < tolerance * test::largest(r));
  }
}

namespace {

/// What a step that must fail says, with # for each number that is above zero.
std::string failure(const Parts& parts, Vec y) {
  try {
    parts.solve(parts.pressing(2), y);
  } catch (const SolverFailure& failure) {
    return std::regex_replace(failure.what(), std::regex("[1-9]\\.[0-9]+e[-+][0-9]+"), "#");
  }
  return "it did not fail";
}

} // namespace

TEST_CASE("a VI that does not converge ends with reason and residual", "[contact]") {
  const test::Option option("-full_vi_snes_max_it", "0");
  const Parts parts({"solver.vi=full"});
  petsc::Vector y = parts.space.vector();
  CHECK(failure(parts, y) ==
        "the full_vi did not converge: DIVERGED_MAX_IT, scaled residual # after 0 iterations");
}

TEST_CASE("an iterative solve that does not converge ends with reason and residual", "[contact]") {
  const test::Option option("-step_ksp_max_it", "2");
  const Parts parts({"solver.linear=iterative"});
  petsc::Vector y = parts.space.vector();
  CHECK_THAT(failure(parts, y),
             Catch::Matchers::StartsWith("the solve with the step operator D by CG with ") &&
                 Catch::Matchers::EndsWith(" failed: DIVERGED_ITS, residual #, limit #, after 2 iterations"));
}

namespace {

/// D p + Nμ = 0 with p·ν = value on a set: a motion that contact alone makes.
struct Pushed {
  const Parts parts{{"mesh.size=0.1", "solver.linear=iterative"}};
  const contact::ActiveSet set{1, 2, 3, 6};
  const petsc::Vector r = parts.space.vector();
  petsc::Vector p = parts.space.vector();
  std::vector<double> value = std::vector<double>(static_cast<std::size_t>(parts.pairs.count()), -0.1);
  std::vector<double> mu = std::vector<double>(value.size());
  contact::Workspace work = parts.solver.contact()->workspace();

  /// From the guess p.
  void solve() {
    const contact::LinearisedContact step{r, set, {}, value, p, mu};
    parts.solver.contact()->solve_transposed(step, work);
  }

  void check_solution() const {
    petsc::Vector defect = parts.space.vector();
    check(MatMult(parts.D, p, defect));
    const double force = test::largest(defect);
    CHECK(test::largest(mu) > 0.1 * force);
    parts.H.apply(1, mu, defect);
    CHECK(test::largest(defect) < 1e-10 * force);
    std::vector<double> normal(value.size());
    parts.H.apply_transpose(p, normal);
    for (int i : set)
      CHECK(std::abs(normal[static_cast<std::size_t>(i)] - value[static_cast<std::size_t>(i)]) <
            1e-14 * test::largest(p));
  }
};

} // namespace

TEST_CASE("conjugate gradients from a solution are done", "[contact]") {
  Pushed pushed;
  pushed.solve();
  pushed.check_solution();
  long& iterations = count("iterations of conjugate gradients");
  const long before = iterations;
  CHECK(before > 0);
  pushed.solve(); // the residual is rounding, which it would be no use to lower
  CHECK(iterations == before);
  pushed.check_solution();
}

TEST_CASE("conjugate gradients keep what contact prescribes, however far residuals fall", "[contact]") {
  // Below the rounding of the forces that keep the gaps closed, 1e-16 of them, by a factor of 1e4.
  const test::Option option("-step_ksp_rtol", "1e-20");
  Pushed pushed;
  pushed.solve();
  pushed.check_solution();
}

TEST_CASE("where PETSc's VI solver gives up the set is settled all the same", "[contact]") {
  if (ranks(MPI_COMM_WORLD) > 2)
    return; // one rank asks PETSc's solver and tells the others, two as three
  // Stiff, and far from the previous set: a few primal-dual steps are not enough, so PETSc's solver is asked.
  const Parts parts(
      {"mesh.size=0.01", "material.young=1e6", "contact.on=boundary", "contact.obstacle.point=[0, -0.3]"});
  const petsc::Vector r = parts.pressing(2);
  petsc::Vector y = parts.space.vector(), z = parts.space.vector();
  const contact::ContactState usual = parts.solve(r, y);
  const test::Option option("-condensed_vi_snes_max_it", "0");
  const step::SolverChoice solver(Parts::copy(parts.D), &parts.pairs, parts.scene.solver, true);
  contact::ContactState other(parts.pairs.count());
  contact::Workspace work = solver.contact()->workspace();
  const contact::ActiveSet none;
  const contact::ContactProblem step{r, parts.pairs.psi(), none, other, z};
  solver.contact()->solve(step, work);
  CHECK(usual.count(contact::Status::strong) > 1);
  CHECK(usual.vi_iterations > 5);
  CHECK(other.vi_iterations != usual.vi_iterations);
  CHECK(other.active == usual.active);
  CHECK(test::difference(y, z) < 1e-11 * test::largest(y)); // the condition of so stiff a D costs digits
}
