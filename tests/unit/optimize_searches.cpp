// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize_search.h"
#include <catch2/catch_test_macros.hpp>

using namespace signorini;
using namespace signorini::test;

TEST_CASE("all methods find the bounded minimiser, downhill all the way", "[optimize]") {
  for (Method method : methods) {
    Quadratic problem;
    Record record;
    const auto stop = minimise(method, problem, start, {.max_iterations = 500, .tolerance = 1e-6}, record);
    CHECK(stop == optimize::Stop::gradient_tolerance);
    for (std::size_t i = 0; i < problem.t.size(); ++i)
      CHECK(std::abs(problem.current.x[i] - std::clamp(problem.t[i], -1.0, 1.0)) < 1e-5);
    CHECK(record.rows.size() > 2);
    for (std::size_t i = 1; i < record.rows.size(); ++i)
      CHECK(record.rows[i].objective < record.rows[i - 1].objective);
  }
}

TEST_CASE("a first step that is much too long or short is repaired", "[optimize]") {
  for (Method method : methods)
    for (double factor : {1e8, 1e-8}) {
      CAPTURE(factor);
      Misleading problem;
      problem.factor = factor;
      Record record;
      // Curvatures are 0.75 to 16 on the free values: 21 ln(1/tolerance) gradient steps, and one for each
      // factor of ten.
      const int enough = method == Method::projected_gradient ? 200 : 20;
      const auto stop =
          minimise(method, problem, start, {.max_iterations = enough, .tolerance = 1e-4}, record);
      CHECK(stop == optimize::Stop::gradient_tolerance);
      CHECK(problem.misled);
      for (std::size_t i = 0; i < problem.t.size(); ++i)
        CHECK(std::abs(problem.current.x[i] - std::clamp(problem.t[i], -1.0, 1.0)) < 1e-3);
      CHECK(problem.evaluations < 100);
    }
}

TEST_CASE("projected gradient learns the curvature along its step", "[optimize]") {
  // The same in all directions, and one and a half times that at first: the second step is Newton's.
  Misleading problem;
  problem.lower = -100, problem.upper = 100;
  for (std::size_t i = 0; i < problem.c.size(); ++i)
    problem.c[i] = 3 * problem.w[i];
  problem.factor = 1.5;
  Record record;
  CHECK(minimise(Method::projected_gradient, problem, start, {.max_iterations = 10, .tolerance = 1e-12},
                 record) == optimize::Stop::gradient_tolerance);
  REQUIRE(record.rows.size() == 3);
  CHECK(record.rows[1].objective > 0.05 * record.rows[0].objective);
  CHECK(record.rows[2].objective < 1e-24 * record.rows[0].objective);
}

TEST_CASE("the search says why it stopped", "[optimize]") {
  for (Method method : methods) {
    Record record;
    Coupled limited;
    const Point origin{std::vector<double>(Coupled::n)};
    CHECK(minimise(method, limited, origin, {.max_iterations = 2, .tolerance = 0}, record) ==
          optimize::Stop::iteration_limit);
    CHECK(record.rows.size() == 3);
    Coupled exhausted;
    const auto stop = minimise(method, exhausted, origin, {.max_iterations = 2000, .tolerance = 0}, record);
    // Newton's method may end exactly at the minimiser.
    CHECK((stop == optimize::Stop::no_decrease || record.rows.back().gradient_norm == 0));
    Quadratic stopped;
    stopped.stop_at = 3;
    CHECK(minimise(method, stopped, start, {.max_iterations = 100, .tolerance = 0}, record) ==
          optimize::Stop::interrupted);
    CHECK(stopped.current.x.size() == 4);
    CHECK(stopped.evaluations == 3);
  }
}

TEST_CASE("a value that is not finite is never accepted", "[optimize]") {
  for (Method method : methods) {
    Record record;
    Quadratic trial;
    trial.poison_at = 2;
    CHECK(minimise(method, trial, start, {.max_iterations = 500, .tolerance = 1e-6}, record) ==
          optimize::Stop::gradient_tolerance);
    for (const auto& row : record.rows)
      CHECK(std::isfinite(row.objective));
    Quadratic first;
    first.poison_at = 1;
    CHECK_THROWS_AS((void)minimise(method, first, start, {}, record), SolverFailure);
  }
}

TEST_CASE("a trial that the solver fails at is shortened, and a start that it fails at is an error",
          "[optimize]") {
  for (Method method : methods) {
    INFO("method " << static_cast<int>(method));
    Record record;
    Fragile fragile;
    CHECK(minimise(method, fragile, fragile.start, {.max_iterations = 100, .tolerance = 1e-5}, record) ==
          optimize::Stop::gradient_tolerance);
    CHECK(fragile.failures > 0); // the first step is as long as the curvature far from the minimiser is small
    for (std::size_t i = 0; i < fragile.t.size(); ++i)
      CHECK(std::abs(fragile.current.x[i] - fragile.t[i]) < 1e-3);
    Fragile broken;
    broken.last = 1;
    CHECK(minimise(method, broken, broken.start, {}, record) == optimize::Stop::solver_failed);
    CHECK(broken.current.x == broken.start.x);
    Fragile lost;
    lost.radius = 1;
    CHECK_THROWS_AS((void)minimise(method, lost, lost.start, {}, record), SolverFailure);
    CHECK(lost.failures == 1);
  }
}

TEST_CASE("what is held couples to the rest: all methods end where Karush, Kuhn and Tucker's conditions hold",
          "[optimize]") {
  for (Method method : methods) {
    Coupled problem;
    Record record;
    // Gradient steps: curvatures are 1 to 43.
    const auto stop = minimise(
        method, problem, Point{std::vector<double>(Coupled::n)},
        {.max_iterations = method == Method::projected_gradient ? 600 : 60, .tolerance = 1e-6}, record);
    CHECK(stop == optimize::Stop::gradient_tolerance);
    const Point g = problem.derivative(problem.current);
    int held = 0;
    for (std::size_t i = 0; i < Coupled::n; ++i) {
      const double x = problem.current.x[i];
      held += x == problem.lower || x == problem.upper;
      if (x > problem.lower)
        CHECK(g.x[i] < 1e-4);
      if (x < problem.upper)
        CHECK(g.x[i] > -1e-4);
    }
    CHECK(held > 3);
    CHECK(held < static_cast<int>(Coupled::n) - 3);
  }
}

TEST_CASE("the curved valley is followed to its end", "[optimize]") {
  for (Method method : {Method::lbfgs, Method::newton_cg}) {
    Valley problem;
    Record record;
    const auto stop =
        minimise(method, problem, Point{{1, 3}}, {.max_iterations = 200, .tolerance = 1e-9}, record);
    CHECK(stop == optimize::Stop::gradient_tolerance);
    CHECK(std::abs(problem.current.x[0] - 1) < 1e-6);
    CHECK(std::abs(problem.current.x[1] - 1) < 1e-6);
    CHECK(record.rows.size() < 60);
  }
}

TEST_CASE("negative curvature leads away from a maximum", "[optimize]") {
  for (Method method : {Method::lbfgs, Method::newton_cg}) {
    Wells problem;
    Record record;
    const auto stop = minimise(method, problem, Point{{0.1, -0.01, 0.5}},
                               {.max_iterations = 200, .tolerance = 1e-9}, record);
    CHECK(stop == optimize::Stop::gradient_tolerance);
    for (double x : problem.current.x)
      CHECK(std::abs(std::abs(x) - 1) < 1e-6);
    CHECK(record.rows.size() < 40);
    CHECK((problem.negative > 1) == (method == Method::newton_cg)); // one tells the units
  }
}
