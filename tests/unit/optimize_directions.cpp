// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/lbfgs.h"
#include "optimize/newton_cg.h"
#include "optimize_problems.h"
#include <catch2/catch_test_macros.hpp>
#include <functional>

using namespace signorini;
using namespace signorini::test;

TEST_CASE("a line search ends where J is lower and its slope flatter, or beyond a kink", "[optimize]") {
  // J on the line x = t d from 0, as a function of one variable; d is the steepest descent, of length
  // `length`.
  struct Line : Bounded {
    std::function<std::pair<double, double>(double)> J; ///< with its derivative
    int evaluations = 0;
    Line() { w = {1}, lower = -1e300, upper = 1e300; }
    double value(const Point& u) {
      ++evaluations;
      trial = u;
      return J(u.x[0]).first;
    }
    Point trial_gradient() { return {{J(trial.x[0]).second}}; }
  };
  struct Case {
    std::function<std::pair<double, double>(double)> J;
    double length, least, most; ///< of the first trial; where the search may end
    int evaluations;
  };
  const auto parabola = [](double x) { return std::pair{(x - 1) * (x - 1), 2 * (x - 1)}; };
  const auto kink = [](double x) { return x < 1 ? std::pair{2 - x, -1.0} : std::pair{1 + 3 * (x - 1), 3.0}; };
  // Sufficient: (x − 1)² ≤ 1 − 2e-4 x up to 2 − 2e-4; flatter than 0.9: from 0.1 on.
  for (const Case& c : {Case{parabola, 1, 1, 1, 1},          // the first trial does
                        Case{parabola, 1.9, 1.9, 1.9, 1},    // it need not be good
                        Case{parabola, 2.5, 1.25, 1.25, 2},  // too long: half
                        Case{parabola, 16, 1, 1, 5},         // and again
                        Case{parabola, 0.03, 0.12, 0.12, 3}, // too short: twice, and again
                        Case{parabola, 0.1000001, 0.1, 0.11, 1},
                        Case{kink, 1.2, 1.2, 1.2, 1},      // beyond the kink, where J is lower still
                        Case{kink, 0.75, 1.125, 1.125, 3}, // 0.75 as steep, 1.5 too high, then between
                        Case{kink, 4, 1, 1, 3}}) {
    Line problem;
    problem.J = c.J;
    const Point from{{0}};
    const double J = problem.value(from);
    const optimize::Iterate<Line> at{from, J, problem.trial_gradient()};
    problem.evaluations = 0;
    const auto search = optimize::weak_wolfe_search(problem, at, Point{{c.length}}, {});
    REQUIRE(search.found);
    const double x = search.found->u.x[0];
    CHECK((x >= c.least && x <= c.most));
    CHECK(std::abs(search.length * c.length - x) < 1e-15);
    CHECK(search.found->objective == c.J(x).first);
    CHECK(search.found->g.x[0] == c.J(x).second);
    CHECK(problem.trial.x[0] == x);
    CHECK(problem.evaluations == c.evaluations);
    CHECK_FALSE(search.solver_failed);
  }
  // Uphill from the start on: no way down, and no end of trials.
  Line up;
  up.J = [](double x) { return std::pair{1 + std::abs(x), x > 0 ? 1.0 : -1.0}; };
  CHECK_FALSE(optimize::weak_wolfe_search(up, {Point{{0}}, 1.0, Point{{-1}}}, Point{{1}}, {}).found);
  CHECK(up.evaluations < 60); // 2⁻⁵⁰ is rounding
  // Steep up to a jump to NaN at 1: what is left of the step is rounding, and its lower end is taken.
  Line cliff;
  cliff.J = [](double x) { return std::pair{x < 1 ? 2 - x : NAN, -1.0}; };
  const auto edge = optimize::weak_wolfe_search(cliff, {Point{{0}}, 2.0, Point{{-1}}}, Point{{0.3}}, {});
  REQUIRE(edge.found);
  CHECK((edge.found->u.x[0] > 1 - 1e-14 && edge.found->u.x[0] < 1));
}

TEST_CASE("the secant equation of a pair holds on the values that bounds leave free", "[optimize]") {
  Bounded problem;
  problem.w = {1, 2, 0.5};
  using Iterate = optimize::Iterate<Bounded>;
  // The first value ends at its lower bound, out of which −g points.
  const Iterate from{Point{{-0.7, 0.2, 0.1}}, 1.0, Point{{0.4, 0.9, -0.6}}},
      to{Point{{-1, -0.1, 0.5}}, 0.5, Point{{0.1, 0.3, -0.2}}};
  optimize::LimitedMemory<Bounded> memory{optimize::Options()};
  memory.learn(problem, from, to, 1);
  const Point s{{0, to.u.x[1] - from.u.x[1], to.u.x[2] - from.u.x[2]}},
      y{{0.3, to.g.x[1] - from.g.x[1], to.g.x[2] - from.g.x[2]}}; // blocked like that of `to`
  const Point d = memory.direction(problem, {to.u, to.objective, y});
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    INFO("value " << i << ": " << d.x[i] << " for " << -s.x[i]);
    CHECK(std::abs(d.x[i] + s.x[i]) < 1e-14);
  }
  // Nor does the pair move that value once it is free.
  const Point inside{{0, to.u.x[1], to.u.x[2]}}, g{{0, y.x[1], y.x[2]}};
  CHECK(memory.direction(problem, {inside, to.objective, g}).x[0] == 0);
}

TEST_CASE("a trust region follows what its model was worth", "[optimize]") {
  // So little curvature that each step ends on the boundary: the step's length is the radius.
  struct Flat : Bounded {
    Flat() { w = {1, 2}, lower = -1e300, upper = 1e300; }
    static double value(const Point&) { return 0; }
    Point trial_gradient() { return trial; }
    static Point hessian_product(Point d) {
      d.scale(1e-6);
      return d;
    }
  };
  Flat problem;
  optimize::TruncatedNewton<Flat> newton{optimize::Options()};
  const optimize::Iterate<Flat> from{Point{{7, -3}}, 1.0, Point{{2, 1}}};
  const auto length = [&] { return optimize::norm(problem, newton.direction(problem, from)); };
  // A step of t times the last direction, with so much of the decrease that the model foretold for all of it.
  const auto learn = [&](double t, double ratio) {
    const Point d = newton.direction(problem, from);
    optimize::Iterate<Flat> to = from;
    to.u.add(t, d);
    to.objective += ratio * (problem.inner(from.g, d) + 0.5e-6 * problem.inner(d, d));
    newton.learn(problem, from, to, t);
  };
  const auto is = [](double a, double b) { return std::abs(a / b - 1) < 1e-12; };
  CHECK(is(length(), 2));
  learn(1, 0.5); // fair: as it is
  CHECK(is(length(), 2));
  learn(1, 0.9); // good: twice
  CHECK(is(length(), 4));
  learn(1, 0.1); // poor: half
  CHECK(is(length(), 2));
  learn(0.25, 0.9); // what the search shortened
  CHECK(is(length(), 0.5));
  learn(8, 0.5); // what it lengthened, twice
  CHECK(is(length(), 8));
  CHECK(newton.restart());
  const Point down = newton.direction(problem, from);
  CHECK(is(problem.inner(down, from.g), -8 * optimize::norm(problem, from.g))); // the steepest
  CHECK_FALSE(newton.restart());
  learn(1, 0.9); // what it led to says nothing of the model
  CHECK(is(length(), 8));
}

TEST_CASE("conjugate gradients need a product for each curvature, and solve Newton's equation",
          "[optimize]") {
  // Three curvatures in eight directions; two values are held at a bound that the gradient pushes out of.
  struct Quadric : Bounded {
    int products = 0;
    Quadric() { w = {1, 2, 0.5, 4, 1, 3, 0.2, 1}, lower = -1, upper = 1e300; }
    static double value(const Point&) { return 0; }
    Point trial_gradient() { return trial; }
    Point hessian_product(Point d) {
      ++products;
      for (std::size_t i = 0; i < d.x.size(); ++i)
        d.x[i] *= static_cast<double>(1 + i % 3);
      return d;
    }
  };
  Quadric problem;
  optimize::TruncatedNewton<Quadric> newton{optimize::Options()};
  Point u{std::vector<double>(8, 0.5)}, g{{1, -2, 3, 1, 2, -1, 0.5, 1}};
  u.x[0] = u.x[4] = -1;                         // g > 0 there
  g.scale(1e-3);                                // so that the trust region does not matter
  (void)newton.direction(problem, {u, 0.0, g}); // the gradient at the start is the measure of small ones
  g.scale(1e-12);
  problem.products = 0;
  const Point d = newton.direction(problem, {u, 0.0, g});
  CHECK(problem.products == 3);
  for (std::size_t i = 0; i < 8; ++i) {
    const double exact = i % 4 == 0 ? 0 : -g.x[i] / static_cast<double>(1 + i % 3);
    CHECK(std::abs(d.x[i] - exact) < 1e-13 * optimize::norm(problem, g));
  }
}

TEST_CASE("what is held takes no part in the memory of L-BFGS", "[optimize]") {
  // The same steps with a third value that moves to its bound and is held there.
  Quadratic whole;
  Quadratic part;
  part.w.resize(2);
  optimize::LimitedMemory<Quadratic> with{optimize::Options()}, without{optimize::Options()};
  const auto iterate = [](const Quadratic& problem, double x, double y, double z, double gx, double gy) {
    optimize::Iterate<Quadratic> at{Point{{x, y, z, 0}}, 0.0, Point{{gx, gy, 5 - z, 0}}};
    at.u.x.resize(problem.w.size());
    at.g.x.resize(problem.w.size());
    return at;
  };
  const auto path = [&](const Quadratic& problem) {
    return std::vector{iterate(problem, 0, 0, 0.9, 1, -0.5), iterate(problem, -0.3, 0.2, -1, 0.6, -0.2),
                       iterate(problem, -0.5, 0.1, -1, 0.1, -0.3)};
  };
  const auto a = path(whole), b = path(part);
  for (std::size_t k = 0; k + 1 < a.size(); ++k) {
    with.learn(whole, a[k], a[k + 1], 1);
    without.learn(part, b[k], b[k + 1], 1);
    const Point d = with.direction(whole, a[k + 1]), e = without.direction(part, b[k + 1]);
    CHECK(std::abs(d.x[0] - e.x[0]) < 1e-14);
    CHECK(std::abs(d.x[1] - e.x[1]) < 1e-14);
    CHECK(std::hypot(e.x[0], e.x[1]) > 1e-2);
    CHECK(d.x[2] == 0);
  }
}

TEST_CASE("the memory of L-BFGS goes on in another problem", "[optimize]") {
  const Quadratic problem;
  using Memory = optimize::LimitedMemory<Quadratic>;
  const auto iterate = [](double x, double y) { // J = (x² + 4 y²)/2 in these two
    return optimize::Iterate<Quadratic>{Point{{x, y, 0, 0}}, 0.0, Point{{x, 4 * y, 0, 0}}};
  };
  const std::vector path{iterate(0.9, 0.8), iterate(0.5, 0.6), iterate(0.4, -0.2), iterate(0.1, 0.1)};
  Memory before{optimize::Options()};
  for (std::size_t k = 0; k + 1 < path.size(); ++k)
    before.learn(problem, path[k], path[k + 1], 1);
  const auto directions_differ = [&](const Memory& a, const Memory& b) {
    const Point d = a.direction(problem, path.back()), e = b.direction(problem, path.back());
    return std::hypot(d.x[0] - e.x[0], d.x[1] - e.x[1]);
  };
  Memory same{optimize::Options()}, lost{optimize::Options()}, none{optimize::Options()};
  same.inherit(before, problem, [](const Point& v) { return v; });
  CHECK(directions_differ(before, same) < 1e-15);
  // What interpolation turns round has no curvature that could be used: every second vector is a y.
  int count = 0;
  lost.inherit(before, problem, [&](Point v) {
    v.scale(count++ % 2 ? -1 : 1);
    return v;
  });
  CHECK(count == 6);
  none.inherit(Memory{optimize::Options()}, problem, [](const Point& v) { return v; });
  CHECK(directions_differ(lost, none) > 0.01); // the length of the last step is kept
  CHECK(!lost.restart());
  CHECK(same.restart());
}
