#include "base/collective.h"
#include "base/error.h"
#include "contact/elimination.h"
#include "contact/lcp/complementarity.h"
#include "contact/placement.h"
#include "fixtures.h"
#include "forward/solver_choice.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <regex>

using namespace signorini;
using petsc::check;

namespace {

/// The parts of a contact step on their own.
struct Parts {
  scene::Scene scene;
  mesh::Mesh mesh;
  fem::Space space;
  fem::DirichletDofs clamped;
  petsc::Matrix D;
  contact::ContactPairs pairs;
  contact::NormalOperator N{pairs};
  forward::SolverChoice solver;

  explicit Parts(const std::vector<std::string>& overrides = {})
      : scene(test::parse(test::source("tests/data/block.toml"), overrides)),
        mesh(MPI_COMM_WORLD, scene.mesh), space(mesh, scene.mesh.degree), clamped(space, scene.clamps),
        D(fem::assemble_step_operator(space, scene.materials, scene.time.step)),
        pairs(space, clamped, scene.contacts), solver(copy(D), &pairs, scene.solver, true) {}

  static petsc::Matrix copy(Mat matrix) {
    petsc::Matrix same;
    check(MatDuplicate(matrix, MAT_COPY_VALUES, same.put()));
    return same;
  }

  /// The contact step for r from a previous state (default: all open), y from zero.
  contact::ContactState solve(Vec r, Vec y) const {
    return solve(r, contact::ContactState(pairs.count()), y);
  }
  contact::ContactState solve(Vec r, const contact::ContactState& previous, Vec y) const {
    contact::ContactState state(pairs.count());
    contact::Workspace work = solver.contact()->workspace();
    solver.contact()->solve(r, pairs.psi(), previous.active, state, y, work);
    return state;
  }

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
  REQUIRE(parts.pairs.count() == 5);
  for (int i = 0; i < parts.pairs.count(); ++i) {
    const double* x = &parts.pairs.points()[static_cast<std::size_t>(3 * i)];
    CHECK(std::abs(x[0] - 0.25 * i) < 1e-10); // ordered by coordinates on any number of ranks
    CHECK(std::abs(parts.pairs.psi()[static_cast<std::size_t>(i)] - (0.3 * x[0] + x[1] + 0.1) / n) < 1e-14);
  }
  petsc::Vector y = parts.space.vector();
  check(VecSet(y, -0.05));
  std::vector<double> gap(5);
  parts.N.gap(parts.pairs.psi(), y, gap);
  for (int i = 0; i < 5; ++i)
    CHECK(std::abs(gap[static_cast<std::size_t>(i)] -
                   (parts.pairs.psi()[static_cast<std::size_t>(i)] - 0.05 * 1.3 / n)) < 1e-14);
  check(VecSet(y, -1));
  CHECK_THROWS_AS(contact::place_outside(parts.pairs, y), UserError);
}

TEST_CASE("the condensed matrix is what D says", "[contact]") {
  const Parts parts;
  MumpsSolver D(parts.D);
  D.factorise();
  const contact::StoredColumnsElimination columns(parts.pairs, D, parts.space.vector(), 1e9),
      solves(parts.pairs, D, parts.space.vector(), 0);
  CHECK(columns.bytes() > 0);
  CHECK(solves.bytes() == 0);
  const std::size_t m = static_cast<std::size_t>(parts.pairs.count());
  std::vector<double> lambda{1, -2, 0.5, 3, 0.1}, minus(m), slip(m);
  std::ranges::transform(lambda, minus.begin(), std::negate{});
  petsc::Vector y = parts.space.vector(), zero = parts.space.vector(), direct = parts.space.vector(),
                force = parts.space.vector();
  parts.N.add(1, lambda, force);
  D.solve(force, direct);
  for (const contact::StoredColumnsElimination* elimination : {&columns, &solves}) {
    contact::Prediction prediction = elimination->prediction();
    elimination->predict(zero, prediction, slip);
    CHECK(std::ranges::all_of(slip, [](double s) { return s == 0; }));
    elimination->finish(prediction, minus, y);
    CHECK(test::difference(y, direct) < 1e-13 * test::largest(direct));
    parts.N.normal_components(y, slip);
    const std::vector<double> S = elimination->condensed();
    for (std::size_t i = 0; i < m; ++i) {
      double product = 0;
      for (std::size_t j = 0; j < m; ++j)
        product += S[i * m + j] * lambda[j];
      CHECK(std::abs(product / slip[i] - 1) < 1e-12);
    }
  }
}

TEST_CASE("contact in the corner of the factor is contact everywhere", "[contact]") {
  if (ranks(MPI_COMM_WORLD) > 1)
    return; // CHOLMOD factorises on one rank
  // On both sides of the size from which CHOLMOD works on supernodes.
  for (const char* size : {"mesh.size=0.2", "mesh.size=0.01"}) {
    const Parts parts({size, "contact.on=boundary", "contact.obstacle.point=[0, -9]"});
    const int m = parts.pairs.count();
    std::vector<int> corner;
    for (PetscInt dof : parts.pairs.first_dofs())
      corner.push_back(static_cast<int>(dof / 2));
    SparseCholesky cholesky(parts.D, corner);
    const double estimate = cholesky.estimate();
    cholesky.factorise();
    CHECK(cholesky.bytes() < 1.2 * estimate);
    CHECK(cholesky.bytes() > 0.5 * estimate);
    MumpsSolver mumps(parts.D);
    mumps.factorise();
    const contact::TrailingBlockElimination fast(parts.pairs, cholesky);
    const contact::StoredColumnsElimination slow(parts.pairs, mumps, parts.space.vector(), 0);
    const std::vector<double> S = fast.condensed(), T = slow.condensed();
    double worst = 0;
    for (std::size_t i = 0; i < S.size(); ++i)
      worst = std::max(worst, std::abs(S[i] - T[i]));
    CHECK(worst < 1e-12 * *std::ranges::max_element(T));
    const petsc::Vector r = parts.pressing(1);
    petsc::Vector y = parts.space.vector(), z = parts.space.vector(), target = parts.space.vector();
    mumps.solve(r, target);
    std::vector<double> a(static_cast<std::size_t>(m)), b(a.size()), lambda(a.size());
    contact::Prediction of_fast = fast.prediction(), of_slow = slow.prediction();
    fast.predict(r, of_fast, a);
    slow.predict(r, of_slow, b);
    for (std::size_t i = 0; i < a.size(); ++i) {
      CHECK(std::abs(a[i] - b[i]) < 1e-12 * test::largest(target));
      lambda[i] = i % 3 == 0 ? 0.1 * std::cos(static_cast<double>(i)) * test::largest(r) : 0;
    }
    for (const double scale : {1.0, 0.0, -2.0}) { // repeatable
      for (double& force : lambda)
        force *= scale;
      fast.finish(of_fast, lambda, y);
      slow.finish(of_slow, lambda, z);
      CHECK(test::difference(y, z) < 1e-12 * test::largest(z));
    }
  }
}

TEST_CASE("a factor that does not fit the memory allowed is not made", "[contact]") {
  const Parts fits({"mesh.size=0.02", "solver.memory=1e9"}), exceeds({"mesh.size=0.02", "solver.memory=1e5"}),
      forced({"mesh.size=0.02", "solver.memory=1e5", "solver.linear=direct"});
  CHECK(!fits.solver.takes_guess());
  CHECK(fits.solver.memory().factor > 1e5);
  CHECK(exceeds.solver.takes_guess());
  CHECK(exceeds.solver.memory().condensation == 0);
  CHECK(exceeds.solver.choice().find("0.0001 GB are allowed") != std::string::npos);
  CHECK(!forced.solver.takes_guess());
}

TEST_CASE("MUMPS is given more space where what it set aside falls short", "[contact]") {
  // On several ranks it does at random, as they are loaded. Here it is told to set aside too little.
  if (ranks(MPI_COMM_WORLD) > 1)
    return; // a factorisation that fails there may leave messages to the next one
  constexpr const char* relaxation = "-step_mat_mumps_icntl_14";
  const Parts parts({"mesh.size=0.02"});
  MumpsSolver usual(parts.D);
  usual.factorise();
  petsc::check(PetscOptionsSetValue(nullptr, relaxation, "-50"));
  {
    petsc::Matrix matrix, factor;
    MatFactorInfo info;
    petsc::check(MatConvert(parts.D, MATAIJ, MAT_INITIAL_MATRIX, matrix.put()));
    petsc::check(MatSetOption(matrix, MAT_SPD, PETSC_TRUE));
    petsc::check(MatSetOptionsPrefixFactor(matrix, "step_"));
    petsc::check(MatGetFactor(matrix, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, factor.put()));
    petsc::check(MatFactorInfoInitialize(&info));
    petsc::check(MatCholeskyFactorSymbolic(factor, matrix, nullptr, &info));
    petsc::check(MatCholeskyFactorNumeric(factor, matrix, &info));
    PetscInt error = 0;
    petsc::check(MatMumpsGetInfog(factor, 1, &error));
    REQUIRE(error == -9);
  }
  MumpsSolver tight(parts.D);
  tight.factorise();
  petsc::check(PetscOptionsClearValue(nullptr, relaxation));
  const petsc::Vector r = parts.pressing(0);
  petsc::Vector x = parts.space.vector(), y = parts.space.vector();
  usual.solve(r, x);
  tight.solve(r, y);
  CHECK(test::difference(x, y) < 1e-12 * test::largest(x));
}

TEST_CASE("a factor with more entries than can be numbered is not made", "[contact]") {
  if (ranks(MPI_COMM_WORLD) > 1)
    return; // CHOLMOD factorises on one rank
  const Parts parts({"mesh.size=0.02"});
  SparseCholesky few(parts.D, {}), many(parts.D, {}, 1e4);
  CHECK(few.possible());
  REQUIRE_FALSE(many.possible());
  CHECK(many.estimate() > 8e4);
  CHECK(many.estimate() < few.estimate());
  CHECK_THROWS_AS(many.factorise(), SolverFailure);
}

TEST_CASE("all solvers of the contact step find its solution, which is complementary", "[contact]") {
  for (const std::vector<std::string>& overrides :
       {std::vector<std::string>{},
        {"mesh.degree=2"},
        {"mesh.size=0.1", "contact.obstacle.normal=[-1, 0.4]", "contact.obstacle.point=[0.8, 0]",
         "contact.on=boundary"}}) {
    const auto with = [&](const char* option) {
      std::vector<std::string> all = overrides;
      all.push_back(option);
      return Parts(all);
    };
    const Parts parts = with("solver.vi=condensed"), full = with("solver.vi=full"),
                iterative = with("solver.linear=iterative");
    int closed = 0, open = 0;
    for (int which = 0; which < 6; ++which) {
      const petsc::Vector r = parts.pressing(which);
      petsc::Vector y = parts.space.vector(), z = parts.space.vector(), x = parts.space.vector(),
                    defect = parts.space.vector();
      const contact::ContactState a = parts.solve(r, y), b = full.solve(r, z), c = iterative.solve(r, x);
      CHECK(a.active == b.active);
      CHECK(a.active == c.active);
      CHECK(test::difference(y, z) < 1e-12 * test::largest(y));
      CHECK(test::difference(y, x) < 1e-10 * test::largest(y));
      closed += a.count(contact::Status::strong);
      open += a.count(contact::Status::open);
      // D y = r − Nλ with 0 ≤ λ ⟂ g ≥ 0.
      check(MatMult(parts.D, y, defect));
      check(VecAXPY(defect, -1, r));
      parts.N.add(1, a.lambda, defect);
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
  const petsc::Vector r = parts.pressing(2);
  petsc::Vector cold = parts.space.vector(), warm = parts.space.vector();
  const contact::ContactState first = parts.solve(r, cold);
  REQUIRE(first.count(contact::Status::strong) > 1);
  CHECK(first.vi_iterations > 0);
  CHECK(parts.solve(r, first, warm).vi_iterations == 0);
  CHECK(test::difference(cold, warm) < 1e-14 * test::largest(cold)); // MUMPS sums in no fixed order
}

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
  for (const double unit : {1e-9, 1e9}) {
    petsc::Matrix D = Parts::copy(parts.D);
    check(MatScale(D, unit));
    const forward::SolverChoice solver(std::move(D), &parts.pairs, parts.scene.solver, true);
    const auto solve = [&](const contact::ContactState& expected, Vec r) {
      petsc::Vector scaled = petsc::copy(r), y = parts.space.vector();
      check(VecScale(scaled, unit));
      contact::ContactState state(parts.pairs.count());
      contact::Workspace work = solver.contact()->workspace();
      solver.contact()->solve(scaled, parts.pairs.psi(), {}, state, y, work);
      CHECK(state.status == expected.status);
    };
    petsc::Vector y = parts.space.vector(), r = parts.space.vector();
    for (int which = 0; which < 3; ++which)
      solve(parts.solve(parts.pressing(which), y), parts.pressing(which));
    parts.space.interpolate(scene::Field({"0", "-0.1 - 0.3*x - y"}, "test", false), 0, y);
    check(MatMult(parts.D, y, r));
    solve(parts.solve(r, y), r);
  }
}

TEST_CASE("sliding solves move along the obstacle with normal forces alone", "[contact]") {
  for (const auto& [linear, tolerance] : {std::pair{"direct", 1e-13}, {"iterative", 1e-10}}) {
    const Parts parts({"mesh.degree=2", fmt::format("solver.linear={}", linear)});
    const contact::ActiveSet set{1, 2, 5};
    const petsc::Vector r = parts.pressing(3);
    petsc::Vector p = parts.space.vector(), defect = parts.space.vector();
    contact::Workspace work = parts.solver.contact()->workspace();
    parts.solver.contact()->solve_sliding(r, set, p, work);
    std::vector<double> normal(static_cast<std::size_t>(parts.pairs.count()));
    parts.N.normal_components(p, normal);
    for (int i : set)
      CHECK(std::abs(normal[static_cast<std::size_t>(i)]) < 1e-13 * test::largest(p));
    // What is left of r − D p must be normal forces on the set.
    check(MatMult(parts.D, p, defect));
    check(VecAYPX(defect, -1, r));
    parts.N.normal_components(defect, normal);
    for (std::size_t i = 0; i < normal.size(); ++i)
      if (std::ranges::find(set, static_cast<int>(i)) == set.end())
        normal[i] = 0;
    CHECK(test::largest(defect) > 1e-3 * test::largest(r));
    parts.N.add(-1, normal, defect);
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

/// A PETSc option for as long as this object lives.
struct Option {
  const char* name;
  Option(const char* n, const char* value) : name(n) { check(PetscOptionsSetValue(nullptr, name, value)); }
  ~Option() { (void)PetscOptionsClearValue(nullptr, name); }
};

} // namespace

TEST_CASE("a VI that does not converge ends with reason and residual", "[contact]") {
  const Option option("-full_vi_snes_max_it", "0");
  const Parts parts({"solver.vi=full"});
  petsc::Vector y = parts.space.vector();
  CHECK(failure(parts, y) ==
        "the full_vi did not converge: DIVERGED_MAX_IT, scaled residual # after 0 iterations");
}

TEST_CASE("an iterative solve that does not converge ends with reason and residual", "[contact]") {
  const Option option("-step_ksp_max_it", "2");
  const Parts parts({"solver.linear=iterative"});
  petsc::Vector y = parts.space.vector();
  CHECK_THAT(failure(parts, y),
             Catch::Matchers::StartsWith("the solve with the step operator D by CG with ") &&
                 Catch::Matchers::EndsWith(" failed: DIVERGED_ITS, residual # of # after 2 iterations"));
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
  const Option option("-condensed_vi_snes_max_it", "0");
  const forward::SolverChoice solver(Parts::copy(parts.D), &parts.pairs, parts.scene.solver, true);
  contact::ContactState other(parts.pairs.count());
  contact::Workspace work = solver.contact()->workspace();
  solver.contact()->solve(r, parts.pairs.psi(), {}, other, z, work);
  CHECK(usual.count(contact::Status::strong) > 1);
  CHECK(usual.vi_iterations > 5);
  CHECK(other.vi_iterations != usual.vi_iterations);
  CHECK(other.active == usual.active);
  CHECK(test::difference(y, z) < 1e-11 * test::largest(y)); // the condition of so stiff a D costs digits
}

TEST_CASE("contact is told apart by what rounding leaves of gaps, and of forces by the motion they make",
          "[contact]") {
  const Parts parts;
  const contact::Complementarity complementarity(parts.pairs, parts.D);
  const auto m = static_cast<std::size_t>(parts.pairs.count());
  const petsc::Vector diagonal = fem::diagonal(parts.D), still = parts.space.vector();
  std::vector<double> stiffness(m); // against moving a node alone
  for (std::size_t i = 0; i < m; ++i) {
    std::vector<double> one(m);
    one[i] = 1;
    petsc::Vector normal = parts.space.vector(), product = parts.space.vector();
    parts.N.add(1, one, normal);
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
      contact::ContactState s = state(i, forces * motion, gap);
      CHECK(complementarity.holds(s.lambda, s.gap, allowed, 0));
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
      CHECK_FALSE(complementarity.holds(by_motion.lambda, by_motion.gap, allowed, 0));
      CHECK_FALSE(complementarity.holds_within(allowed, by_gap.lambda, by_gap.gap));
      CHECK(complementarity.holds_within(3 * allowed, by_gap.lambda, by_gap.gap));
      contact::ContactState s = by_motion;
      CHECK_THROWS_AS(complementarity.classify(s, still), SolverFailure);
    }
    for (const auto& [force, gap] : {std::pair{NAN, 0.0}, {0.0, NAN}, {INFINITY, 0.0}, {0.0, INFINITY}}) {
      contact::ContactState s = state(i, force, gap);
      CHECK_THROWS_AS(complementarity.classify(s, still), SolverFailure);
    }
  }
}

TEST_CASE("a direct solver is chosen by the memory of its factor and of two dense matrices of the candidates",
          "[contact]") {
  const std::vector<std::string> many{"mesh.size=0.02", "contact.on=boundary",
                                      "contact.obstacle.point=[0, -9]"};
  const auto with = [&](double memory) {
    std::vector<std::string> settings = many;
    settings.push_back(fmt::format("solver.memory={:.17g}", memory));
    return Parts(settings);
  };
  const Parts parts(many);
  const double m = parts.pairs.count(), dense = 2 * m * m * sizeof(double);
  std::vector<int> corner;
  for (PetscInt dof : parts.pairs.first_dofs())
    corner.push_back(static_cast<int>(dof / 2));
  if (ranks(MPI_COMM_WORLD) > 1) { // MUMPS says whole megabytes, and of another partition of the mesh others
    const double factor = MumpsSolver(parts.D).estimate();
    CHECK_FALSE(with(2 * factor + dense).solver.takes_guess());
    CHECK(with(factor / 2).solver.takes_guess());
    return;
  }
  const double factor = SparseCholesky(parts.D, corner).estimate();
  REQUIRE(dense > 1e-3 * factor); // a hundredth of it is then far beyond the rounding of their sum
  CHECK_FALSE(with(factor + 1.01 * dense).solver.takes_guess());
  CHECK(with(factor + 0.99 * dense).solver.takes_guess());
  // On one rank contact is condensed by the factor's last block, with no column of D⁻¹ to keep for each
  // candidate.
  CHECK(parts.solver.memory().condensation < 0.5 * m * parts.space.dofs() * sizeof(double));
}
