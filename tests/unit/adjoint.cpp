// SPDX-License-Identifier: GPL-3.0-or-later
#include "adjoint/enriched_body.h"
#include "adjoint/sweep.h"
#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>

using namespace signorini;
using petsc::check;
using petsc::dot;

namespace {

/// The block at the end of a run in which it is in contact, with the contact of each step.
struct InContact {
  test::Ready ready;
  test::Recorded trajectory;
  std::vector<int> contact_steps;

  explicit InContact(const std::vector<std::string>& overrides = {})
      : ready("tests/data/block.toml", overrides), trajectory(ready.problem) {
    for (int k = 1; k <= trajectory.steps; ++k)
      if (!trajectory.contact[static_cast<std::size_t>(k)].active.empty())
        contact_steps.push_back(k);
  }
};

/// Settings of the schemes, of contact-stabilized stepping by conjugate gradients, and of two branches that
/// relax.
const std::vector<std::vector<std::string>> schemes{
    {},
    {"contact.mass=massless"},
    {"time.scheme=contact-stabilized"},
    {"time.scheme=contact-stabilized", "solver.linear=iterative"},
    {"material.prony=[{g=0.4, k=0.1, time=0.05}, {g=0.2, k=0, time=2}]"}};

/// Steps in which the predictor was projected.
int projected(const test::Recorded& trajectory) {
  return static_cast<int>(std::ranges::count_if(
      trajectory.contact, [](const contact::ContactState& contact) { return !contact.predictor.empty(); }));
}

} // namespace

TEST_CASE("the sweep is the transpose of the linearised steps", "[adjoint]") {
  for (const std::vector<std::string>& scheme : schemes) {
    const InContact run(scheme);
    const bool stabilized = run.ready.scene.contact_scheme() == scene::ContactScheme::contact_stabilized,
               iterative = run.ready.scene.solver.linear == scene::LinearMethod::iterative;
    CHECK((projected(run.trajectory) > 1) == stabilized);
    const step::Stepper& stepper = run.ready.problem.stepper;
    const fem::Space& space = run.ready.problem.space;
    REQUIRE(run.contact_steps.size() > 1);
    step::State from = stepper.state(), to = stepper.state();
    const petsc::Vector product = space.vector();
    step::Stepper::Workspace work = stepper.workspace();
    double forward = 0, backward = 0;
    for (int k = 1; k <= run.trajectory.steps; ++k) {
      const petsc::Vector density = test::smooth(space, k);
      stepper.linearised_step({run.ready.problem.grid.scheme(k), from, {{.density = density}}, to},
                              run.trajectory.contact[static_cast<std::size_t>(k)], work);
      check(MatMult(*run.ready.problem.operators.W, test::smooth(space, -k), product));
      forward += dot(to.y(), product);
      std::swap(from, to);
    }
    const test::Dual smooth([&](int k, Vec out) { check(VecAXPY(out, 1, test::smooth(space, -k))); });
    adjoint::sweep(stepper, work, run.ready.problem.grid, run.trajectory.sets(), {space, smooth},
                   [&](int k, Vec p) {
                     check(MatMult(*run.ready.problem.operators.W, test::smooth(space, k), product));
                     backward += run.ready.problem.grid.scheme(1).impulse() * dot(p, product);
                   });
    CHECK(std::abs(forward) > 0);
    CHECK(std::abs(forward - backward) < (iterative ? 1e-9 : 1e-12) * std::abs(forward));
  }
}

TEST_CASE("the linearised step is the derivative of the step", "[adjoint]") {
  for (const std::vector<std::string>& scheme : schemes) {
    const InContact run(scheme);
    const bool stabilized = run.ready.scene.contact_scheme() == scene::ContactScheme::contact_stabilized,
               iterative = run.ready.scene.solver.linear == scene::LinearMethod::iterative;
    CHECK((projected(run.trajectory) > 1) == stabilized);
    const step::Stepper& stepper = run.ready.problem.stepper;
    const fem::Space& space = run.ready.problem.space;
    const int k = run.contact_steps.at(run.contact_steps.size() / 2);
    const std::size_t i = static_cast<std::size_t>(k);
    const petsc::Vector dload = test::smooth(space, 3), load = space.vector();
    const step::State change = stepper.state();
    step::State found = stepper.state(), linear = stepper.state();
    check(VecCopy(test::smooth(space, 1), change.y()));
    check(VecCopy(test::smooth(space, 2), change.v()));
    for (std::size_t j = 0; j < change.q().size(); ++j)
      check(VecCopy(test::smooth(space, 4 + static_cast<int>(j)), change.q()[j]));
    check(VecCopy(run.ready.problem.load().at(run.ready.problem.grid.step(k)).density, load));
    contact::ContactState moved(stepper.pairs()->count());
    step::Stepper::Workspace work = stepper.workspace();
    // A step is piecewise affine: no truncation, only rounding, so that the largest ε that keeps the sets is
    // the best.
    double epsilon = 1;
    do {
      epsilon /= 10;
      REQUIRE(epsilon > 1e-6);
      const step::State from = stepper.state();
      const petsc::Vector f = petsc::copy(load);
      check(VecWAXPY(from.y(), epsilon, change.y(), run.trajectory.y[i - 1]));
      check(VecWAXPY(from.v(), epsilon, change.v(), run.trajectory.v[i - 1]));
      for (std::size_t j = 0; j < change.q().size(); ++j)
        check(VecWAXPY(from.q()[j], epsilon, change.q()[j], run.trajectory.q[i - 1][j]));
      check(VecAXPY(f, epsilon, dload));
      stepper.step({run.ready.problem.grid.step(k), from, {{.density = f}}, run.trajectory.contact[i - 1]},
                   {found, moved}, work);
    } while (moved.active != run.trajectory.contact[i].active ||
             moved.predictor != run.trajectory.contact[i].predictor);
    REQUIRE(!moved.active.empty());
    stepper.linearised_step({run.ready.problem.grid.scheme(k), change, {{.density = dload}}, linear}, moved,
                            work);
    check(VecAXPY(found.y(), -1, run.trajectory.y[i]));
    check(VecAXPY(found.v(), -1, run.trajectory.v[i]));
    for (std::size_t j = 0; j < found.q().size(); ++j)
      check(VecAXPY(found.q()[j], -1, run.trajectory.q[i][j]));
    for (const petsc::Vector& part : found.parts())
      check(VecScale(part, 1 / epsilon));
    // What rounding, or a few times the solver's tolerance, leaves of two displacements; velocities are 2/τ
    // times as much.
    const double off = (iterative ? 10 * stepper.solver().tolerance() : 1e-14) *
                       test::largest(run.trajectory.y[i]) / epsilon;
    CHECK(off < 1e-4 * test::largest(linear.y())); // else it says nothing
    CHECK(test::difference(found.y(), linear.y()) < off);
    CHECK(test::difference(found.v(), linear.v()) < run.ready.problem.grid.scheme(1).rate() * off);
    for (std::size_t j = 0; j < found.q().size(); ++j)
      CHECK(test::difference(found.q()[j], linear.q()[j]) < 2 * off);
  }
}

TEST_CASE("the sweep solves (4.40)-(4.41) with sliding conditions", "[adjoint]") {
  const InContact run({"mesh.degree=2"});
  const problem::Problem& problem = run.ready.problem;
  const step::Stepper& stepper = problem.stepper;
  const double tau = problem.grid.length(1);
  const std::size_t N = static_cast<std::size_t>(run.trajectory.steps);
  std::vector<petsc::Vector> p(N + 2);
  const auto dual = [&](int k) {
    petsc::Vector product = problem.space.vector();
    check(MatMult(*problem.operators.W, test::smooth(problem.space, k), product));
    return product;
  };
  const test::Dual smooth([&](int k, Vec out) { check(VecAXPY(out, 1, test::smooth(problem.space, k))); });
  step::Stepper::Workspace work = stepper.workspace();
  adjoint::sweep(stepper, work, problem.grid, run.trajectory.sets(), {problem.space, smooth},
                 [&](int k, Vec pk) { p[static_cast<std::size_t>(k)] = petsc::copy(pk); });

  // The paper's recursion, written out with matrices: D = M + τ/2 B + τ²/4 A, R = M + τ/2 B − τ²/4 A.
  const fem::Operators& body = problem.operators;
  const auto apply = [&](double a, Vec x, Vec out) { // out = (M + τ/2 B + a τ²/4 A) x
    petsc::Vector product = petsc::zero_like(x);
    check(MatMult(body.M, x, out));
    check(MatMult(*body.B, x, product));
    check(VecAXPY(out, tau / 2, product));
    check(MatMult(body.A, x, product));
    check(VecAXPY(out, a * tau * tau / 4, product));
  };
  petsc::Vector q = problem.space.vector(), defect = problem.space.vector(), part = problem.space.vector();
  std::vector<double> normal(static_cast<std::size_t>(stepper.pairs()->count()));
  int sliding = 0;
  for (std::size_t k = N; k >= 1; --k) {
    apply(1, p[k], defect);
    check(VecAXPY(defect, -1, dual(static_cast<int>(k))));
    const double size = test::largest(defect);
    if (k < N) {
      apply(-1, p[k + 1], part);
      check(VecAXPY(defect, -1, part));
      check(MatMult(body.M, q, part));
      check(VecAXPY(defect, tau, part));
    }
    // What is left is μ_k: normal forces on A_k.
    const contact::ActiveSet active = run.trajectory.contact[k].active;
    stepper.pairs()->rows().apply_transpose(defect, normal);
    for (std::size_t i = 0; i < normal.size(); ++i)
      if (std::ranges::find(active, static_cast<int>(i)) == active.end())
        normal[i] = 0;
    stepper.pairs()->rows().apply(-1, normal, defect);
    CHECK(test::largest(defect) < 1e-11 * size);
    stepper.pairs()->rows().apply_transpose(p[k], normal);
    for (int i : active)
      CHECK(std::abs(normal[static_cast<std::size_t>(i)]) < 1e-12 * test::largest(p[k]));
    sliding += !active.empty();
    if (k == N) { // q_N = −2/τ p_N
      check(VecAXPBY(q, -2 / tau, 0, p[N]));
    } else { // q_k = −q_{k+1} + 2/τ (p_{k+1} − p_k)
      check(VecAXPBYPCZ(q, 2 / tau, -2 / tau, -1, p[k + 1], p[k]));
    }
  }
  CHECK(sliding > 1);
}

TEST_CASE("adjoint states vanish on the clamp", "[adjoint]") {
  const test::Ready ready("scenes/half-disc.toml", {"mesh.size=3", "load.body=[\"0\", \"-1e6\"]"});
  const test::Recorded trajectory(ready.problem);
  CHECK(std::ranges::any_of(trajectory.contact,
                            [](const contact::ContactState& state) { return !state.active.empty(); }));
  int steps = 0;
  const test::Dual smooth(
      [&](int k, Vec out) { check(VecAXPY(out, 1, test::smooth(ready.problem.space, k))); });
  step::Stepper::Workspace work = ready.problem.stepper.workspace();
  adjoint::sweep(ready.problem.stepper, work, ready.problem.grid, trajectory.sets(),
                 {ready.problem.space, smooth}, [&](int, Vec p) {
                   petsc::Vector rest = petsc::copy(p);
                   ready.problem.stepper.clamped().clear(rest);
                   CHECK(test::difference(rest, p) == 0);
                   steps += test::largest(p) > 0;
                   petsc::Vector seed = test::smooth(ready.problem.space, 1),
                                 free = petsc::copy(seed); // which is not zero there
                   ready.problem.stepper.clamped().clear(free);
                   CHECK(test::difference(free, seed) > 0.1);
                 });
  CHECK(steps == trajectory.steps);
}

TEST_CASE("bubbles slide in the middle of edges in contact, and nowhere else", "[adjoint]") {
  // Candidates in the corner: 0 of the left side, 1 of the bottom; from there 2 to 5 up the left side, 6 to 9
  // along the bottom.
  const test::Ready ready(
      "tests/data/block.toml",
      {"contact=[{on=\"left\", obstacle={shape=\"half-space\", point=[-0.1, 0], normal=[1, 0.2]}}, "
       "{on=\"bottom\", obstacle={shape=\"half-space\", point=[0, -0.1], normal=[0.3, 1]}}]"});
  const adjoint::EnrichedBody body(ready.problem.space, ready.problem.stepper.pairs(), ready.scene);
  const petsc::Vector x = test::smooth(body.space(), 1);
  petsc::Vector free = petsc::copy(x), held = body.space().vector();
  body.keep_bubbles({}, free);
  struct Middle {
    double x, y;
    std::array<double, 2> normal;
  };
  const std::array<double, 2> left{1, 0.2}, bottom{0.3, 1};
  for (const auto& [active, middles] : std::vector<std::pair<contact::ActiveSet, std::vector<Middle>>>{
           {{0, 6}, {}}, // one end is in contact with another obstacle
           {{3, 5, 7, 9}, {}},
           {{1, 6}, {{0.125, 0, bottom}}},
           {{0, 2}, {{0, 0.125, left}}},
           {{0, 1, 2, 6, 8, 9}, {{0, 0.125, left}, {0.125, 0, bottom}, {0.875, 0, bottom}}},
           {{3, 4, 5}, {{0, 0.625, left}, {0, 0.875, left}}}}) {
    CAPTURE(active, middles);
    check(VecCopy(x, held));
    body.keep_bubbles(active, held);
    const petsc::ReadArray a(free), b(held);
    long found = 0, different = 0;
    for (int node = 0; node < body.space().owned_nodes(); ++node) {
      const auto i = static_cast<std::size_t>(2 * node), j = static_cast<std::size_t>(3 * node);
      const double *at = &body.space().points()[j], change[]{b[i] - a[i], b[i + 1] - a[i + 1]};
      const auto middle = std::ranges::find_if(
          middles, [&](const Middle& m) { return std::hypot(m.x - at[0], m.y - at[1]) < 1e-9; });
      different += change[0] != 0 || change[1] != 0;
      if (middle == middles.end())
        continue;
      ++found;
      const auto& [n0, n1] = middle->normal;
      CHECK(std::abs(n0 * a[i] + n1 * a[i + 1]) > 1e-4);
      CHECK(std::abs(n0 * b[i] + n1 * b[i + 1]) < 1e-15);
      CHECK(std::abs(n1 * change[0] - n0 * change[1]) < 1e-15); // along ν alone
    }
    CHECK(test::total(found) == static_cast<long>(middles.size()));
    CHECK(test::total(different) == static_cast<long>(middles.size()));
  }
}

TEST_CASE("bubbles of the adjoint states take up what the run's duals leave", "[adjoint]") {
  // As viscous as stiff within a step, so that each term of the residual matters.
  const test::Ready ready("tests/data/block.toml", {"material.viscosity={bulk=0.5, shear=0.5}"});
  const step::Stepper& stepper = ready.problem.stepper;
  const adjoint::EnrichedBody body(ready.problem.space, stepper.pairs(), ready.scene);
  const fem::Operators& operators = body.operators();
  const double tau = ready.problem.grid.length(1);
  const petsc::Vector pushed = test::smooth(body.space(), 3);
  const test::Dual at_step_4({}, [&](int k, Vec out) {
    if (k == 4)
      check(VecAXPY(out, 1, pushed));
  });
  const step::DualAtStep derivative(body.space(), at_step_4);
  adjoint::DualBubbles bubbles(body, derivative, ready.problem.grid);
  adjoint::Duals duals(stepper, ready.problem.grid);
  const contact::ActiveSet active{1, 2};
  petsc::Vector before = body.space().vector(), residual = body.space().vector(),
                product = body.space().vector(), embedded = body.space().vector(),
                diagonal = fem::diagonal(operators.A);
  check(VecScale(diagonal, tau));
  check(VecAXPY(diagonal, 1, fem::diagonal(*operators.B)));
  const auto add = [&](Mat matrix, Vec x, double factor) {
    check(MatMult(matrix, x, product));
    check(VecAXPY(residual, factor, product));
  };
  const auto weighed = [&] { // by which the bubbles' equation is solved to a hundredth
    body.keep_bubbles(active, residual);
    check(VecPointwiseDivide(product, residual, diagonal));
    return dot(product, residual);
  };
  // A derivative alone; what viscosity carries on of its bubbles; and duals of each kind in turn.
  for (int k = 4; k >= -1; --k) {
    petsc::Vector* const kinds[]{&duals.p, &duals.p_later, &duals.velocity, &duals.velocity_later};
    for (int kind = 0; kind < 4; ++kind) {
      check(VecZeroEntries(*kinds[kind]));
      if (kind == 2 - k)
        check(VecCopy(test::smooth(ready.problem.space, 5 + kind), *kinds[kind]));
    }
    check(VecCopy(bubbles.last(), before));
    const Vec b = bubbles.next(k, duals, active);
    check(VecZeroEntries(residual));
    if (k == 4)
      check(VecCopy(pushed, residual));
    const auto embed = [&](Vec x) -> Vec {
      body.embed(x, embedded);
      return embedded;
    };
    add(operators.M, embed(duals.velocity), 3 / tau);
    add(operators.M, embed(duals.velocity_later), -1 / tau);
    add(operators.M, embed(duals.p), -1);
    add(*operators.B, embed(duals.p_later), tau / 2);
    add(*operators.B, embed(duals.p), -tau / 2);
    add(operators.A, embed(duals.p), -tau * tau / 4);
    add(operators.A, embed(duals.p_later), -tau * tau / 4);
    add(*operators.B, before, 1);
    petsc::Vector whole = petsc::copy(residual);
    const double size = weighed();
    INFO("step " << k);
    CHECK(size > 0);
    const auto left = [&](Vec x) {
      check(VecCopy(whole, residual));
      add(operators.A, x, -tau);
      add(*operators.B, x, -1);
      return weighed();
    };
    const double guessed = left(before); // the last bubbles are the first guess
    CHECK(left(b) < 1.1e-4 * std::max(size, guessed));
    // Each of them alone is more than that.
    check(VecCopy(whole, residual));
    add(*operators.B, b, -1);
    CHECK(weighed() > 1e-2 * size);
    check(VecCopy(whole, residual));
    add(operators.A, b, -tau);
    CHECK(weighed() > 1e-2 * size);
  }
}
