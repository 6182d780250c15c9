#include "fixtures.h"
#include <catch2/catch_test_macros.hpp>

using namespace signorini;

namespace {

control::Control some(const control::ControlSpace& controls, int which) {
  control::Control u = controls.zero();
  for (int k = 1; k <= controls.steps(); ++k)
    petsc::check(VecAXPY(u.at(k), 1, test::smooth(controls.space(), which + k)));
  return u;
}

} // namespace

TEST_CASE("the product is that of L2(0,T; L2)", "[control]") {
  const test::Ready ready("tests/data/block.toml");
  const ControlProblem problem(ready.problem, test::silent());
  const control::Control u = problem.controls.interpolate({"2", "t"}, "test"), one = problem.controls.interpolate({"0", "1"}, "test");
  const double T = ready.scene.time.end;
  CHECK(std::abs(problem.controls.product(one, one) / T - 1) < 1e-12);
  CHECK(std::abs(problem.controls.product(u, one) / (T * T / 2) - 1) < 1e-12); // midpoint rule, exact for t
}

TEST_CASE("clipping is the projection in the metric of a bounded control", "[control]") {
  for (const char* degree : {"mesh.degree=1", "mesh.degree=2"}) {
    const test::Ready ready("tests/data/block.toml", {"control.lower=-0.4", "control.upper=[0.3, 0.6]", degree});
    const ControlProblem problem(ready.problem, test::silent());
    const control::Control u = some(problem.controls, 0);
    control::Control clipped = u;
    problem.controls.project(clipped);
    control::Control residual = u;
    residual.add(-1, clipped);
    REQUIRE(problem.controls.metric(residual, residual) > 0);
    // ⟨u − Pu, w − Pu⟩ ≤ 0 for every admissible w characterises the projection.
    for (int which = 1; which < 6; ++which) {
      control::Control w = some(problem.controls, 3 * which);
      problem.controls.project(w);
      w.add(-1, clipped);
      CHECK(problem.controls.metric(residual, w) <= 1e-14);
    }
    // Both metrics weigh constants alike, and represent the same functional.
    const control::Control one = problem.controls.interpolate({"1", "0"}, "test");
    CHECK(std::abs(problem.controls.metric(one, one) / problem.controls.product(one, one) - 1) < 1e-12);
    control::Control g = some(problem.controls, 7);
    const double functional = problem.controls.product(g, u);
    problem.controls.to_metric(g);
    CHECK(std::abs(problem.controls.metric(g, u) - functional) < 1e-12 * std::abs(functional));
  }
}

TEST_CASE("J is the trapezoidal rule of its integrals", "[control]") {
  // No motion at all: y = 0, y_d = (t, 0): tracking ½∫t² by the trapezoidal rule, terminal γT².
  const test::Ready ready("tests/data/block.toml", {"objective.desired={displacement=[\"t\", \"0\"]}", "load.body=[\"0\", \"0\"]",
                                                     "initial.velocity=[\"0\", \"0\"]"});
  ControlProblem problem(ready.problem, test::silent());
  problem.reduced.value(problem.controls.zero());
  problem.reduced.accept();
  const double T = ready.scene.time.end, tau = ready.scene.time.step;
  const control::Value& value = problem.reduced.value();
  CHECK(std::abs(value.tracking / (T * T * T / 6 + tau * tau * T / 12) - 1) < 1e-12);
  CHECK(std::abs(value.terminal / (ready.scene.objective->gamma * T * T) - 1) < 1e-12);
  CHECK(value.control_cost == 0);
}

TEST_CASE("at the reference control only the cost of the control is left", "[control]") {
  const test::Ready ready("tests/data/block.toml");
  ControlProblem problem(ready.problem, test::silent());
  problem.reduced.value(*problem.reference);
  problem.reduced.accept();
  const control::Value& value = problem.reduced.value();
  // Not exactly: on several ranks MUMPS sums in no fixed order, so that two runs differ by rounding.
  CHECK(value.tracking < 1e-24);
  CHECK(value.terminal < 1e-24);
  CHECK(std::abs(value.control_cost / (ready.scene.objective->alpha / 2 * 1.09 * ready.scene.time.end) - 1) < 1e-12);
  control::Control g = problem.reduced.gradient();
  g.add(-ready.scene.objective->alpha, *problem.reference);
  CHECK(problem.controls.norm(g) < 1e-12);
}

TEST_CASE("a rejected trial changes nothing", "[control]") {
  const test::Ready ready("tests/data/block.toml");
  ControlProblem problem(ready.problem, test::silent());
  const control::Control u = some(problem.controls, 0), other = some(problem.controls, 4);
  const double value = problem.reduced.value(u);
  problem.reduced.accept();
  const control::Control before = problem.reduced.gradient();
  problem.reduced.value(other);
  control::Control after = problem.reduced.gradient();
  after.add(-1, before);
  CHECK(problem.controls.norm(before) > 0);
  CHECK(problem.controls.norm(after) < 1e-12 * problem.controls.norm(before));
  CHECK(problem.reduced.value().total() == value);
}
