#include "optimize/projected_gradient.h"
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <numeric>
#include <vector>

using namespace signorini;

namespace {

struct Point {
  std::vector<double> x;
  void add(double a, const Point& other) {
    for (std::size_t i = 0; i < x.size(); ++i)
      x[i] += a * other.x[i];
  }
};

/// ½ Σ c_i (x_i − t_i)² over lower ≤ x ≤ upper in the metric Σ w_i x_i y_i: minimiser clip(t).
struct Quadratic {
  using Vector = Point;
  std::vector<double> c{1, 4, 8, 3}, t{2, -3, 0.5, 0.1}, w{1, 2, 0.5, 4};
  double lower = -1, upper = 1;
  double poison_at = std::numeric_limits<double>::infinity(); ///< the evaluation that returns NaN
  int evaluations = 0, stop_at = 1'000'000;
  Point current, trial;

  double value(const Point& u) {
    if (++evaluations >= stop_at)
      throw Interrupted();
    trial = u;
    if (evaluations == poison_at)
      return std::numeric_limits<double>::quiet_NaN();
    double sum = 0;
    for (std::size_t i = 0; i < c.size(); ++i)
      sum += c[i] / 2 * (u.x[i] - t[i]) * (u.x[i] - t[i]);
    return sum;
  }
  void accept() { current = trial; }
  Point gradient() {
    Point g = current;
    for (std::size_t i = 0; i < c.size(); ++i)
      g.x[i] = c[i] * (current.x[i] - t[i]) / w[i];
    return g;
  }
  double inner(const Point& a, const Point& b) const {
    double sum = 0;
    for (std::size_t i = 0; i < w.size(); ++i)
      sum += w[i] * a.x[i] * b.x[i];
    return sum;
  }
  void project(Point& u) const {
    for (double& x : u.x)
      x = std::clamp(x, lower, upper);
  }
};

struct Record {
  std::vector<optimize::Iteration> rows;
  void operator()(const optimize::Iteration& row) { rows.push_back(row); }
};

const Point start{{0, 0, 0, 5}};

} // namespace

TEST_CASE("projected gradient finds the bounded minimiser, downhill all the way", "[optimize]") {
  Quadratic problem;
  Record record;
  const auto stop = optimize::projected_gradient(problem, start, {.max_iterations = 500, .tolerance = 1e-6}, record);
  CHECK(stop == optimize::Stop::gradient_tolerance);
  for (std::size_t i = 0; i < problem.t.size(); ++i)
    CHECK(std::abs(problem.current.x[i] - std::clamp(problem.t[i], -1.0, 1.0)) < 1e-5);
  CHECK(record.rows.size() > 3);
  for (std::size_t i = 1; i < record.rows.size(); ++i)
    CHECK(record.rows[i].objective < record.rows[i - 1].objective);
}

TEST_CASE("a first step that is much too long or short is repaired", "[optimize]") {
  for (double length : {1e8, 1e-8}) {
    Quadratic problem;
    Record record;
    const auto stop = optimize::projected_gradient(
        problem, start, {.max_iterations = 5000, .tolerance = 1e-4, .first_step = length}, record);
    CHECK(stop == optimize::Stop::gradient_tolerance);
  }
}

TEST_CASE("the search says why it stopped", "[optimize]") {
  Record record;
  Quadratic limited;
  CHECK(optimize::projected_gradient(limited, start, {.max_iterations = 3, .tolerance = 0}, record) ==
        optimize::Stop::iteration_limit);
  CHECK(record.rows.size() == 4);
  Quadratic exhausted;
  CHECK(optimize::projected_gradient(exhausted, start, {.max_iterations = 100'000, .tolerance = 0}, record) ==
        optimize::Stop::no_decrease);
  Quadratic stopped;
  stopped.stop_at = 6;
  CHECK(optimize::projected_gradient(stopped, start, {.max_iterations = 100, .tolerance = 0}, record) ==
        optimize::Stop::interrupted);
  CHECK(stopped.current.x.size() == 4);
}

TEST_CASE("a value that is not finite is never accepted", "[optimize]") {
  Record record;
  Quadratic trial;
  trial.poison_at = 4;
  CHECK(optimize::projected_gradient(trial, start, {.max_iterations = 500, .tolerance = 1e-6}, record) ==
        optimize::Stop::gradient_tolerance);
  for (const auto& row : record.rows)
    CHECK(std::isfinite(row.objective));
  Quadratic first;
  first.poison_at = 1;
  CHECK_THROWS_AS((void)optimize::projected_gradient(first, start, {}, record), SolverFailure);
}

TEST_CASE("a trial that the solver fails at is shortened, and a start that it fails at is an error", "[optimize]") {
  struct Fragile : Quadratic {
    double radius = 6; ///< the solver fails outside
    double value(const Point& u) {
      for (double x : u.x)
        if (std::abs(x) > radius)
          throw SolverFailure("too far");
      return Quadratic::value(u);
    }
    void project(Point&) const {}
  };
  Record record;
  Fragile fragile;
  CHECK(optimize::projected_gradient(fragile, start, {.max_iterations = 500, .tolerance = 1e-5, .first_step = 1e6},
                                     record) == optimize::Stop::gradient_tolerance);
  Fragile lost;
  lost.radius = 1;
  CHECK_THROWS_AS((void)optimize::projected_gradient(lost, start, {}, record), SolverFailure);
}
