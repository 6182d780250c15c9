// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "optimize/report.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <span>
#include <utility>
#include <vector>

/// Small problems whose minimisers are known, or what is true of them.
namespace signorini::test {

struct Point {
  std::vector<double> x;
  void add(std::span<const double> a, std::span<const Point> others) {
    for (std::size_t i = 0; i < others.size(); ++i)
      add(a[i], others[i]);
  }
  void add(double a, const Point& other) {
    for (std::size_t i = 0; i < x.size(); ++i)
      x[i] += a * other.x[i];
  }
  void scale(double a) {
    for (double& value : x)
      value *= a;
  }
  static void combine(std::vector<Point>& points, const std::vector<std::vector<double>>& factors) {
    std::vector<Point> sums(factors.size(), points.front());
    for (std::size_t j = 0; j < factors.size(); ++j) {
      sums[j].scale(0);
      sums[j].add(factors[j], points);
    }
    points = std::move(sums);
  }
};

/// What the test problems share: the metric Σ w_i x_i y_i, bounds, and the points.
struct Bounded {
  using Vector = Point;
  using Compact = Point;
  std::vector<double> w;
  double lower = -1, upper = 1;
  Point current, trial;

  void accept() { current = trial; }
  double inner(const Point& a, const Point& b) const {
    double sum = 0;
    for (std::size_t i = 0; i < w.size(); ++i)
      sum += w[i] * a.x[i] * b.x[i];
    return sum;
  }
  Point dual(Point u) const {
    for (std::size_t i = 0; i < w.size(); ++i)
      u.x[i] *= w[i];
    return u;
  }
  static std::vector<double> pairings(std::span<const Point> a, std::span<const Point> b) {
    std::vector<double> products;
    for (const Point& dual : a)
      for (const Point& point : b)
        products.push_back(std::inner_product(dual.x.begin(), dual.x.end(), point.x.begin(), 0.0));
    return products;
  }
  bool bounded() const { return lower > -1e300 || upper < 1e300; }
  void project(Point& u) const {
    for (double& x : u.x)
      x = std::clamp(x, lower, upper);
  }
  void zero_blocked(Point& v, const Point& u, const Point& d) const {
    for (std::size_t i = 0; i < v.x.size(); ++i)
      if ((u.x[i] <= lower && d.x[i] < 0) || (u.x[i] >= upper && d.x[i] > 0))
        v.x[i] = 0;
  }
  /// From partial derivatives to the Riesz representative.
  Point riesz(Point derivative) const {
    for (std::size_t i = 0; i < w.size(); ++i)
      derivative.x[i] /= w[i];
    return derivative;
  }
};

/// ½ Σ c_i (x_i − t_i)²: minimiser clip(t).
struct Quadratic : Bounded {
  std::vector<double> c{1, 4, 8, 3}, t{2, -3, 0.5, 0.1};
  double poison_at = std::numeric_limits<double>::infinity(); ///< the evaluation that returns NaN
  int evaluations = 0, stop_at = 1'000'000;

  Quadratic() { w = {1, 2, 0.5, 4}; }
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
  Point trial_gradient() {
    Point g = trial;
    for (std::size_t i = 0; i < c.size(); ++i)
      g.x[i] = c[i] * (trial.x[i] - t[i]);
    return riesz(g);
  }
  Point hessian_product(const Point& d) {
    Point h = d;
    for (std::size_t i = 0; i < c.size(); ++i)
      h.x[i] *= c[i];
    return riesz(h);
  }
};

/// A quadratic whose Hessian at the first guess is wrong by a factor, as that of contact which is about to
/// change.
struct Misleading : Quadratic {
  double factor = 1;
  bool misled = false;
  Point hessian_product(const Point& d) {
    Point h = Quadratic::hessian_product(d);
    if (!std::exchange(misled, true))
      h.scale(factor);
    return h;
  }
};

/// Σ c_i √(1 + (x_i − t_i)²), ever flatter away from t, so that Newton's step from there is much too long;
/// outside of a radius a solver fails.
struct Fragile : Quadratic {
  double radius = 10;
  int failures = 0, last = 1'000'000; ///< evaluations after the last one fail too
  Point start{t};

  Fragile() {
    lower = -1e300, upper = 1e300;
    for (double& x : start.x)
      x += 4;
  }
  double value(const Point& u) {
    if (std::ranges::any_of(u.x, [&](double x) { return std::abs(x) > radius; }) || evaluations >= last) {
      ++failures;
      throw SolverFailure("too far");
    }
    ++evaluations;
    trial = u;
    double sum = 0;
    for (std::size_t i = 0; i < c.size(); ++i)
      sum += c[i] * std::hypot(1, u.x[i] - t[i]);
    return sum;
  }
  Point trial_gradient() {
    Point g = trial;
    for (std::size_t i = 0; i < c.size(); ++i)
      g.x[i] = c[i] * (trial.x[i] - t[i]) / std::hypot(1, trial.x[i] - t[i]);
    return riesz(g);
  }
  Point hessian_product(const Point& d) {
    Point h = d;
    for (std::size_t i = 0; i < c.size(); ++i)
      h.x[i] *= c[i] / std::pow(std::hypot(1, current.x[i] - t[i]), 3);
    return riesz(h);
  }
};

/// ½ xᵀQx − bᵀx with Q = tridiagonal (−1, 2 + i, −1): coupled, so that what is held changes the rest.
struct Coupled : Bounded {
  static constexpr std::size_t n = 40;
  Coupled() {
    for (std::size_t i = 0; i < n; ++i)
      w.push_back(1 + 0.1 * static_cast<double>(i % 7));
    lower = -0.5, upper = 0.25;
  }
  static double b(std::size_t i) { return 3 * std::sin(0.4 * static_cast<double>(i)); }
  static Point product(const Point& x) {
    Point q = x;
    for (std::size_t i = 0; i < n; ++i)
      q.x[i] =
          (2 + static_cast<double>(i)) * x.x[i] - (i > 0 ? x.x[i - 1] : 0) - (i + 1 < n ? x.x[i + 1] : 0);
    return q;
  }
  double value(const Point& u) {
    trial = u;
    const Point q = product(u);
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i)
      sum += u.x[i] * (q.x[i] / 2 - b(i));
    return sum;
  }
  Point derivative(const Point& u) const {
    Point g = product(u);
    for (std::size_t i = 0; i < n; ++i)
      g.x[i] -= b(i);
    return g;
  }
  Point trial_gradient() { return riesz(derivative(trial)); }
  Point hessian_product(const Point& d) { return riesz(product(d)); }
};

/// max over two quadratics, ½|x − a|² and ½|x + a|² + 1/2, without bounds. With |a| = 1 both are 25/32 at the
/// minimiser, x = −a/4, where the gradients −5a/4 and 3a/4 have 0 between them.
struct Kinked : Bounded {
  std::vector<double> a{0.6, 0.8, 0};
  Kinked() { w = {1, 3, 2}, lower = -1e300, upper = 1e300; }
  std::pair<double, double> parts(const Point& u) const {
    double first = 0, second = 0.5;
    for (std::size_t i = 0; i < a.size(); ++i) {
      first += (u.x[i] - a[i]) * (u.x[i] - a[i]) / 2;
      second += (u.x[i] + a[i]) * (u.x[i] + a[i]) / 2;
    }
    return {first, second};
  }
  double value(const Point& u) {
    trial = u;
    const auto [first, second] = parts(u);
    return std::max(first, second);
  }
  Point trial_gradient() {
    const auto [first, second] = parts(trial);
    Point g = trial;
    for (std::size_t i = 0; i < a.size(); ++i)
      g.x[i] += (first > second ? -1 : 1) * a[i];
    return riesz(g);
  }
  Point hessian_product(const Point& d) { return riesz(d); }
};

/// max over m convex quadratics of different curvature in n dimensions.
struct Pieces : Bounded {
  std::size_t n, m;
  std::vector<std::vector<double>> centre, curvature;
  std::vector<double> height;
  std::size_t at_trial = 0, at_current = 0;

  Pieces(unsigned seed, double bound, std::size_t dimensions = 10, std::size_t pieces = 6)
      : n(dimensions), m(pieces) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform;
    lower = -bound, upper = bound;
    for (std::size_t i = 0; i < n; ++i)
      w.push_back(0.5 + uniform(random));
    for (std::size_t j = 0; j < m; ++j) {
      height.push_back(0.1 * uniform(random));
      centre.push_back({});
      curvature.push_back({});
      for (std::size_t i = 0; i < n; ++i) {
        centre.back().push_back(2 * uniform(random) - 1);
        curvature.back().push_back(0.1 + uniform(random));
      }
    }
  }
  void accept() {
    Bounded::accept();
    at_current = at_trial;
  }
  double value(const Point& u) {
    trial = u;
    double most = -1e300;
    for (std::size_t j = 0; j < m; ++j) {
      double sum = height[j];
      for (std::size_t i = 0; i < n; ++i)
        sum += curvature[j][i] / 2 * (u.x[i] - centre[j][i]) * (u.x[i] - centre[j][i]);
      if (sum > most)
        most = sum, at_trial = j;
    }
    return most;
  }
  Point trial_gradient() {
    Point g = trial;
    for (std::size_t i = 0; i < n; ++i)
      g.x[i] = curvature[at_trial][i] * (trial.x[i] - centre[at_trial][i]);
    return riesz(g);
  }
  Point hessian_product(const Point& d) {
    Point h = d;
    for (std::size_t i = 0; i < n; ++i)
      h.x[i] *= curvature[at_current][i];
    return riesz(h);
  }
};

/// Rosenbrock's function in the plane.
struct Valley : Bounded {
  Valley() { w = {2, 0.5}, lower = -1e300, upper = 1e300; }
  double value(const Point& u) {
    trial = u;
    const double x = u.x[0], y = u.x[1];
    return 100 * (y - x * x) * (y - x * x) + (1 - x) * (1 - x);
  }
  Point trial_gradient() {
    const double x = trial.x[0], y = trial.x[1];
    return riesz({{-400 * x * (y - x * x) - 2 * (1 - x), 200 * (y - x * x)}});
  }
  Point hessian_product(const Point& d) {
    const double x = current.x[0], y = current.x[1];
    const Point h{
        {(1200 * x * x - 400 * y + 2) * d.x[0] - 400 * x * d.x[1], -400 * x * d.x[0] + 200 * d.x[1]}};
    return riesz(h);
  }
};

/// Σ (x_i² − 1)²/4: minimisers at ±1 in each direction, maxima at zero.
struct Wells : Bounded {
  int negative = 0; ///< Hessian products with negative curvature
  Wells() { w = {1, 2, 0.5}, lower = -1e300, upper = 1e300; }
  double value(const Point& u) {
    trial = u;
    double sum = 0;
    for (double x : u.x)
      sum += (x * x - 1) * (x * x - 1) / 4;
    return sum;
  }
  Point trial_gradient() {
    Point g = trial;
    for (double& x : g.x)
      x = x * x * x - x;
    return riesz(g);
  }
  Point hessian_product(const Point& d) {
    Point h = d;
    for (std::size_t i = 0; i < d.x.size(); ++i)
      h.x[i] *= 3 * current.x[i] * current.x[i] - 1;
    const Point product = riesz(h);
    negative += inner(product, d) < 0;
    return product;
  }
};

} // namespace signorini::test
