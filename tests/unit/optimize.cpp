#include "optimize/lbfgs.h"
#include "optimize/newton_cg.h"
#include "optimize/projected_gradient.h"
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

using namespace signorini;

namespace {

struct Point {
  std::vector<double> x;
  void add(std::span<const double> a, std::span<const optimize::Shared<Point>> others) {
    for (std::size_t i = 0; i < others.size(); ++i)
      add(a[i], *others[i]);
  }
  void add(double a, const Point& other) {
    for (std::size_t i = 0; i < x.size(); ++i)
      x[i] += a * other.x[i];
  }
  void scale(double a) {
    for (double& value : x)
      value *= a;
  }
};

/// What the test problems share: the metric Σ w_i x_i y_i, bounds, and the points.
struct Bounded {
  using Vector = Point;
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
  static std::vector<double> pairings(const Point& a, std::span<const optimize::Shared<Point>> b) {
    std::vector<double> products;
    for (const optimize::Shared<Point>& point : b)
      products.push_back(std::inner_product(a.x.begin(), a.x.end(), point->x.begin(), 0.0));
    return products;
  }
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

/// The same problem with controls c times as large and J k times.
template <class P>
struct InOtherUnits {
  using Vector = Point;
  P given;
  double c, k;
  Point current{}, trial{};

  static Point times(Point x, double factor) {
    x.scale(factor);
    return x;
  }
  double value(const Point& u) {
    trial = u;
    return k * given.value(times(u, 1 / c));
  }
  Point trial_gradient() { return times(given.trial_gradient(), k / c); }
  Point hessian_product(const Point& d) { return times(given.hessian_product(times(d, 1 / c)), k / c); }
  void accept() {
    current = trial;
    given.accept();
  }
  double inner(const Point& a, const Point& b) const { return given.inner(a, b); }
  Point dual(const Point& u) const { return given.dual(u); }
  static std::vector<double> pairings(const Point& a, std::span<const optimize::Shared<Point>> b) {
    return P::pairings(a, b);
  }
  void project(Point& u) const { bounds().project(u); }
  void zero_blocked(Point& v, const Point& u, const Point& d) const { bounds().zero_blocked(v, u, d); }
  [[nodiscard]] Bounded bounds() const { return {{}, c * given.lower, c * given.upper, {}, {}}; }
};

/// Writes no checkpoints.
struct NoCheckpointer {
  static bool restore(auto&) { return false; }
  static bool due(const optimize::Iteration&) { return false; }
  static void store(auto&) {}
  static void restored(double, double) {}
};

struct Record {
  std::vector<optimize::Iteration> rows;
  void operator()(const optimize::Iteration& row) { rows.push_back(row); }
};

const Point start{{0, 0, 0, 5}};

enum class Method { projected_gradient, lbfgs, newton_cg };
constexpr Method methods[] = {Method::projected_gradient, Method::lbfgs, Method::newton_cg};

template <class P, class Checkpointer = NoCheckpointer>
optimize::Result<Point> search(Method method, P& problem, const Point& from, const optimize::Options& options,
                               Record& record, const Checkpointer& keeper = {}) {
  switch (method) {
  case Method::lbfgs:
    return optimize::minimize<optimize::Lbfgs>(problem, from, options, record, keeper);
  case Method::newton_cg:
    return optimize::minimize<optimize::NewtonCg>(problem, from, options, record, keeper);
  default:
    return optimize::minimize<optimize::ProjectedGradient>(problem, from, options, record, keeper);
  }
}

template <class P>
optimize::Stop minimise(Method method, P& problem, const Point& from, const optimize::Options& options,
                        Record& record) {
  return search(method, problem, from, options, record).stop;
}

/// That a search went down to a kink, that its certificate is what it says, by the gradients at its points,
/// and that J, which is convex, is nowhere near as low as the tolerance, relative to the first norm, tells
/// apart.
void require_certified(Pieces& problem, const optimize::Result<Point>& ending, const Record& record,
                       double tolerance) {
  REQUIRE(ending.stop == optimize::Stop::kink);
  REQUIRE(ending.certificate);
  const Point u = problem.current;
  const double J = problem.value(u), first = record.rows.front().gradient_norm;
  for (std::size_t i = 1; i < record.rows.size(); ++i)
    CHECK(record.rows[i].objective < record.rows[i - 1].objective);
  CHECK(record.rows.back().gradient_norm > 1e-3 * first); // a kink it is
  const auto& certificate = *ending.certificate;
  CHECK(certificate.length <= tolerance * first);
  CHECK(certificate.points.size() >= 2);
  CHECK(certificate.radius < 1e-3); // of a control that is of the order of one
  Point sum = u;
  sum.scale(0);
  double whole = 0;
  for (std::size_t i = 0; i < certificate.points.size(); ++i) {
    Point offset = certificate.points[i], inside = offset;
    offset.add(-1, u);
    problem.project(inside);
    CHECK(inside.x == certificate.points[i].x);
    CHECK(std::sqrt(problem.inner(offset, offset)) <= certificate.radius * (1 + 1e-9));
    CHECK(certificate.weights[i] > 0);
    whole += certificate.weights[i];
    sum.add(certificate.weights[i], optimize::evaluated(problem, certificate.points[i])->g);
  }
  CHECK(std::abs(whole - 1) < 1e-12);
  if (problem.lower < -1e299)
    CHECK(std::abs(std::sqrt(problem.inner(sum, sum)) - certificate.length) <= 1e-9 * first);
  CHECK(optimize::stationarity(problem, u, sum) <= 1.01 * tolerance * first);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int run = 0; run < 200; ++run) {
    Point other = u;
    for (double& x : other.x)
      x += 1e-3 * normal(random);
    problem.project(other);
    CHECK(problem.value(other) >= J - 1e-2 * tolerance * first);
  }
}

} // namespace

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

/// That a search does the same in units of the control of `c` and of J of `k`, but for a relative difference.
template <class P>
void require_same(Method method, const P& given, const Point& from, const optimize::Options& options,
                  double c, double k, double difference) {
  INFO("method " << static_cast<int>(method) << ", u by " << c << ", J by " << k);
  P problem = given;
  InOtherUnits<P> other{given, c, k};
  Record record, other_record;
  Point guess = from;
  guess.scale(c);
  const auto ending = search(method, problem, from, options, record);
  const auto other_ending = search(method, other, guess, options, other_record);
  REQUIRE(other_ending.stop == ending.stop);
  REQUIRE(other_record.rows.size() == record.rows.size());
  const auto close = [&](double found, double expected, double size) {
    return std::abs(found - expected) <= difference * std::abs(size);
  };
  const double first = record.rows.front().gradient_norm;
  for (std::size_t i = 0; i < record.rows.size(); ++i) {
    const auto &a = record.rows[i], &b = other_record.rows[i];
    CHECK(close(b.objective / k, a.objective, a.objective));
    CHECK(close(b.gradient_norm * c / k, a.gradient_norm, first));
    const double unit = method == Method::projected_gradient ? c * c / k : 1;
    CHECK(close(b.step_length / unit, a.step_length, a.step_length));
  }
  for (std::size_t i = 0; i < problem.current.x.size(); ++i)
    CHECK(close(other.current.x[i] / c, problem.current.x[i], 1));
  REQUIRE(other_ending.certificate.has_value() == ending.certificate.has_value());
  if (!ending.certificate)
    return;
  const auto &a = *ending.certificate, &b = *other_ending.certificate;
  CHECK(close(b.length * c / k, a.length, a.length));
  CHECK(close(b.radius / c, a.radius, a.radius));
  REQUIRE(b.points.size() == a.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i)
    CHECK(close(b.weights[i], a.weights[i], 1));
}

TEST_CASE("units of powers of two change no digit of a search", "[optimize]") {
  const double big = std::ldexp(1, 30), small = std::ldexp(1, -30);
  for (Method method : methods)
    for (const auto& [c, k] :
         {std::pair{big, 1.0}, {small, 1.0}, {1.0, big}, {1.0, small}, {big, small}, {small, small}}) {
      const optimize::Options options{.max_iterations = 60, .tolerance = 1e-7};
      require_same(method, Quadratic(), start, options, c, k, 0);
      require_same(method, Coupled(), Point{std::vector<double>(Coupled::n)}, options, c, k, 0);
      require_same(method, Valley(), Point{{1, 3}}, options, c, k, 0);
      require_same(method, Wells(), Point{{0.1, -0.01, 0.5}}, options, c, k, 0);
      require_same(method, Fragile(), Fragile().start, options, c, k, 0);
      require_same(method, Kinked(), Point{{2, -1, 1}}, options, c, k, 0);
      optimize::Options among_kinks = options; // where an iteration gathers many gradients
      among_kinks.max_iterations = 25;
      for (const double bound : {0.35, 1e300})
        require_same(method, Pieces(2, bound), Point{std::vector<double>(10, 0.3)}, among_kinks, c, k, 0);
    }
}

TEST_CASE("other units round, and change no more", "[optimize]") {
  for (Method method : methods)
    for (const double c : {1e-9, 3.7, 1e9})
      for (const double k : {1e-9, 0.3, 1e9}) {
        const optimize::Options options{.max_iterations = 5, .tolerance = 1e-7};
        require_same(method, Quadratic(), start, options, c, k, 1e-6);
        require_same(method, Coupled(), Point{std::vector<double>(Coupled::n)}, options, c, k, 1e-6);
        require_same(method, Fragile(), Fragile().start, options, c, k, 1e-6);
        require_same(method, Pieces(2, 0.35), Point{std::vector<double>(10, 0.3)}, options, c, k, 1e-6);
      }
}

TEST_CASE("a problem's units are found where its Hessian tells nothing", "[optimize]") {
  struct Flat : Quadratic { // as far as can be seen
    static Point hessian_product(Point d) {
      d.scale(0);
      return d;
    }
  };
  const auto units = [](double c, double k, bool bounded) {
    Flat flat;
    if (!bounded)
      flat.lower = -1e300, flat.upper = 1e300;
    InOtherUnits<Flat> problem{flat, c, k};
    Point u{{0, 0, 0, 0}};
    const double J = problem.value(u);
    const Point g = problem.trial_gradient();
    problem.accept();
    return optimize::measured(problem, u, J, g);
  };
  for (const bool bounded : {false, true}) {
    const optimize::Units here = units(1, 1, bounded);
    CHECK(here.length > 0.5);
    CHECK(here.length < 10); // the minimiser is 5 away, the bounds 2.7
    for (const double c : {1e-9, 1e9})
      for (const double k : {1e-9, 1e9}) {
        const optimize::Units there = units(c, k, bounded);
        CHECK(std::abs(there.length / (c * here.length) - 1) < 1e-12);
        CHECK(std::abs(there.objective() / (k * here.objective()) - 1) < 1e-12);
        CHECK(std::abs(there.gradient() / (k / c * here.gradient()) - 1) < 1e-12);
      }
  }
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

TEST_CASE("a minimiser on a kink is found where the gradient does not vanish", "[optimize]") {
  for (Method method : {Method::lbfgs, Method::newton_cg}) {
    Kinked problem;
    Record record;
    const auto stop =
        minimise(method, problem, Point{{2, -1, 1}}, {.max_iterations = 500, .tolerance = 1e-8}, record);
    CHECK(stop == optimize::Stop::kink);
    const double x[] = {-0.15, -0.2, 0};
    for (std::size_t i = 0; i < 3; ++i)
      CHECK(std::abs(problem.current.x[i] - x[i]) < 1e-7);
    CHECK(record.rows.back().gradient_norm > 0.1);
    CHECK(record.rows.size() < 30);
  }
}

TEST_CASE("where many pieces meet the search ends with a certificate", "[optimize]") {
  int held = 0;
  for (Method method : {Method::lbfgs, Method::newton_cg})
    for (const bool bounded : {false, true})
      for (unsigned seed = 1; seed <= 3; ++seed) {
        INFO("method " << static_cast<int>(method) << ", seed " << seed << (bounded ? ", bounds" : ""));
        Pieces problem(seed, bounded ? 0.35 : 1e300);
        Record record;
        const auto ending = search(method, problem, Point{std::vector<double>(problem.n, 0.3)},
                                   {.max_iterations = 500, .tolerance = 1e-7}, record);
        require_certified(problem, ending, record, 1e-7);
        CHECK(record.rows.size() < 250); // 30 to 160, by the pieces that it comes by
        const auto at_bounds = std::ranges::count_if(
            problem.current.x, [&](double x) { return x == problem.lower || x == problem.upper; });
        held += at_bounds > 0;
      }
  CHECK(held >= 3); // of 6
}

TEST_CASE("where more pieces meet than a model keeps, what is certified is the minimum", "[optimize]") {
  for (unsigned seed = 3; seed <= 5; ++seed) {
    std::vector<double> values;
    for (Method method : {Method::lbfgs, Method::newton_cg}) {
      INFO("method " << static_cast<int>(method) << ", seed " << seed);
      Pieces problem(seed, 1e300, 30, 200);
      Record record;
      const auto ending = search(method, problem, Point{std::vector<double>(problem.n, 0.3)},
                                 {.max_iterations = 2000, .tolerance = 1e-5}, record);
      require_certified(problem, ending, record, 1e-5);
      values.push_back(record.rows.back().objective);
    }
    // J is convex: at a distance of at most one its values differ by the lengths of the certificates, 3e-5,
    // and what J curves within their radii, (3e-4)².
    CHECK(std::abs(values[0] - values[1]) < 1e-4);
  }
}

TEST_CASE("a certificate among more pieces than a model keeps is not of nothing", "[optimize]") {
  // Here a model that may drop the piece of the current point finds none near it, and no gradient at all to
  // be short.
  std::vector<double> values;
  for (Method method : {Method::newton_cg, Method::lbfgs}) {
    INFO("method " << static_cast<int>(method));
    Pieces problem(8, 1e300, 30, 200);
    Record record;
    const auto ending = search(method, problem, Point{std::vector<double>(problem.n, 0.3)},
                               {.max_iterations = 1500, .tolerance = 1e-7}, record);
    require_certified(problem, ending, record, 1e-7);
    values.push_back(record.rows.back().objective);
  }
  CHECK(std::abs(values[0] - values[1]) < 1e-6); // as above
}

namespace {

/// What a search stored: numbers, lists of numbers and vectors by name.
struct Archive {
  std::map<std::string, std::vector<double>> numbers;
  std::map<std::string, optimize::Shared<Point>> vectors;
};

struct Writer {
  Archive& archive;
  void operator()(const std::string& name, double value) { archive.numbers[name] = {value}; }
  void operator()(const std::string& name, const std::vector<double>& values) {
    archive.numbers[name] = values;
  }
  void operator()(const std::string& name, const optimize::Shared<Point>& u) { archive.vectors[name] = u; }
};

struct Reader {
  const Archive& archive;
  template <class Number>
    requires std::is_arithmetic_v<Number>
  void operator()(const std::string& name, Number& value) {
    value = static_cast<Number>(archive.numbers.at(name).at(0));
  }
  void operator()(const std::string& name, std::vector<double>& values) { values = archive.numbers.at(name); }
  void operator()(const std::string& name, optimize::Shared<Point>& u) { u = archive.vectors.at(name); }
};

/// Stores a search at one iteration, or goes on from where one was stored.
struct StoredAt {
  Archive& archive;
  int iteration;
  bool going_on = false;
  bool restore(auto& state) const {
    if (going_on) {
      Reader reader{archive};
      state.serialize(reader);
    }
    return going_on;
  }
  bool due(const optimize::Iteration& at) const { return !going_on && at.number == iteration; }
  void store(auto& state) const {
    if (!due(state.iteration))
      return;
    Writer writer{archive};
    state.serialize(writer);
  }
  static void restored(double stored, double found) {
    CHECK(std::abs(stored / found - 1) < 1e-15);
  } // in other units
};

} // namespace

TEST_CASE("a search that was stored anywhere goes on to the last bit", "[optimize]") {
  const optimize::Options options{.max_iterations = 28, .tolerance = 1e-7};
  const Point from{std::vector<double>(10, 0.3)};
  for (Method method : methods)
    for (const double bound : {1e300, 0.35}) {
      Pieces problem(3, bound);
      Record whole;
      const auto ending = search(method, problem, from, options, whole);
      const int last = whole.rows.back().number;
      REQUIRE(last > 20); // among the kinks
      for (int stored : {0, 1, 4, 11, 20}) {
        INFO("method " << static_cast<int>(method) << ", bound " << bound << ", stored at " << stored
                       << " of " << last);
        Archive archive;
        Record before, after;
        Pieces one(3, bound), other(3, bound);
        (void)search(method, one, from, options, before, StoredAt{archive, stored});
        REQUIRE(!archive.vectors.empty());
        const auto end = search(method, other, Point{std::vector<double>(10, -0.2)}, options, after,
                                StoredAt{archive, stored, true});
        CHECK(other.current.x == problem.current.x);
        CHECK(end.stop == ending.stop);
        REQUIRE(after.rows.size() == static_cast<std::size_t>(last - stored));
        for (std::size_t i = 0; i < after.rows.size(); ++i) {
          const optimize::Iteration &here = after.rows[i],
                                    &there = whole.rows[static_cast<std::size_t>(stored) + 1 + i];
          REQUIRE(here.number == there.number);
          REQUIRE(here.objective == there.objective);
          REQUIRE(here.gradient_norm == there.gradient_norm);
          REQUIRE(here.step_length == there.step_length);
        }
        REQUIRE(end.certificate.has_value() == ending.certificate.has_value());
        if (end.certificate)
          CHECK(end.certificate->length == ending.certificate->length);
      }
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

TEST_CASE("known curvature is that of the Hessian, and the least known elsewhere", "[optimize]") {
  using optimize::Coordinates;
  constexpr std::size_t n = 5;
  const auto apply = [](const std::vector<double>& B, const Coordinates& x) {
    Coordinates y(n);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        y[i] += B[j * n + i] * (j < x.size() ? x[j] : 0);
    return y;
  };
  const auto distance = [](Coordinates a, const Coordinates& b) {
    optimize::add(a, -1, b);
    return optimize::norm(a);
  };
  // A diagonal Hessian, known along its axes: there it is found, and elsewhere the least of it.
  optimize::Curvature axes;
  CHECK(axes.empty());
  CHECK(axes.largest() == 1);
  const Coordinates x{0.3, -0.2, 0.5, 0.7, -1}, at_first = apply(axes.matrix(n).value(), x);
  CHECK(distance(at_first, x) == 0);
  axes.learn({0, 2}, {0, 6});
  CHECK(distance(apply(axes.matrix(n).value(), x), {0.9, -0.6, 1.5, 2.1, -3}) < 1e-14);
  axes.learn({0, 0, 0, 0.5}, {0, 0, 0, 0.25});
  axes.learn({4}, {32});
  CHECK_FALSE(axes.empty());
  CHECK(axes.largest() == 8);
  CHECK(distance(apply(axes.matrix(n).value(), x), {2.4, -0.6, 0.25, 0.35, -0.5}) < 1e-14);
  axes.forget_oldest(); // of curvature 3
  CHECK(distance(apply(axes.matrix(n).value(), x), {2.4, -0.1, 0.25, 0.35, -0.5}) < 1e-14);
  // A full one, H = 2 I + G Gᵀ, by directions that are not orthogonal: B d = H d, B is symmetric and at least
  // as large as the least of what is known.
  const std::vector<Coordinates> G{{1, 2, 0, -1, 0.5}, {0, 1, -1, 3, 2}, {0.5, 0, 1, 1, -2}};
  const auto H = [&](const Coordinates& d) {
    Coordinates y = optimize::scaled(d, 2);
    for (const Coordinates& g : G)
      optimize::add(y, optimize::dot(g, d), g);
    return y;
  };
  const std::vector<Coordinates> directions{{1, 0.5}, {0.2, 1, -0.3}, {-0.4, 0.1, 0.6, 2, 1}};
  optimize::Curvature full;
  double least = 1e300, largest = 0;
  for (const Coordinates& d : directions) {
    const Coordinates y = H(d);
    full.learn(d, y);
    least = std::min(least, optimize::dot(d, y) / optimize::dot(d, d));
    largest = std::max(largest, optimize::norm(y) / optimize::norm(d));
  }
  CHECK(std::abs(full.largest() / largest - 1) < 1e-15);
  const std::vector<double> B = full.matrix(n).value();
  for (const Coordinates& d : directions)
    CHECK(distance(apply(B, d), H(d)) < 1e-13 * optimize::norm(H(d)));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < i; ++j)
      CHECK(std::abs(B[i * n + j] - B[j * n + i]) < 1e-13 * largest);
  // Along what is orthogonal to all directions and to what they were taken to there is the least curvature
  // alone.
  optimize::Curvature two;
  two.learn({1}, {3, 1});
  two.learn({0, 1}, {1, 5, 2});
  const Coordinates rest{0, 0, 0, 0.6, -0.8};
  CHECK(distance(apply(two.matrix(n).value(), rest), optimize::scaled(rest, 3)) < 1e-14);
}

TEST_CASE("a bundle model of pieces of one curvature is exact, wherever its point is", "[optimize]") {
  using optimize::Coordinates;
  // J = max over i of ½ x·Hx + a_i·x + c_i, H = diag(2, 5). The first two meet in x_1 = 0, where J is least
  // in (0, −1/5); the third lies 3 below the first in the origin.
  const std::vector<Coordinates> a{{1, 1}, {-1, 1}, {0, -2}};
  const double c[] = {0, 0, -3};
  const auto H = [](const Coordinates& x) { return Coordinates{2 * x[0], 5 * x[1]}; };
  const auto gradient = [&](std::size_t i, const Coordinates& x) {
    Coordinates g = H(x);
    optimize::add(g, 1, a[i]);
    return g;
  };
  const auto piece = [&](std::size_t i, const Coordinates& x) {
    return optimize::dot(x, H(x)) / 2 + optimize::dot(a[i], x) + c[i];
  };
  const auto near = [](double x, double y) { return std::abs(x - y) < 1e-14; };
  const auto cut = [&](std::size_t i, const Coordinates& x) {
    const Coordinates g = gradient(i, x);
    return optimize::Cut{g, g, {}, 0};
  };
  Coordinates x{0.75, 0.5};
  optimize::BundleModel model({}, {cut(0, x)});
  const auto meet = [&](std::size_t i, const Coordinates& s) {
    Coordinates there = x;
    optimize::add(there, 1, s);
    const double J = piece(0, x), above = model.null_step(gradient(i, there), s, H(s), J - piece(i, there));
    CHECK(near(above, piece(i, x) - J));
  };
  meet(1, {-1.5, 0.25});
  meet(2, {0.125, 4});
  const Coordinates step{-0.5, -1};
  const double before = piece(0, x);
  optimize::add(x, 1, step);
  model.serious_step(gradient(0, x), step, H(step), before - piece(0, x));
  const std::size_t pieces[] = {0, 0, 1, 2}; // the point's own one is the first
  REQUIRE(model.cuts().size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    const optimize::Cut& found = model.cuts()[i];
    CHECK(near(found.linearisation_error, piece(0, x) - piece(pieces[i], x)));
    for (std::size_t k = 0; k < 2; ++k)
      CHECK(near(found.here[k], gradient(pieces[i], x)[k]));
  }
  const auto direction = optimize::model_minimiser(model.cuts(), {2, 0, 0, 5}, 2).value();
  CHECK(near(x[0] + direction.d[0], 0));
  CHECK(near(x[1] + direction.d[1], -0.2));
  CHECK(near(direction.predicted, piece(0, x) - piece(0, {0, -0.2})));
  CHECK(near(direction.subgradient.weights[2], 0.5));
  CHECK(near(direction.subgradient.weights[3], 0));
  CHECK(near(direction.subgradient.length, optimize::norm(H(direction.d))));
  CHECK_FALSE(optimize::model_minimiser(model.cuts(), {2, 3, 3, 4}, 2));
  // Between the gradients at the point, (1.5, −1.5), and at the offset (−1, 1.25) to the second piece,
  // (−2.5, 4.75), the shortest is perpendicular to their difference. The third is 5 away.
  const auto shortest = [&](double radius) {
    return optimize::minimum_norm_subgradient(model.cuts(), radius);
  };
  CHECK(near(shortest(0.1).length, optimize::norm(gradient(0, x))));
  const Coordinates here = gradient(0, x), there = gradient(1, {-0.75, 0.75});
  Coordinates edge = there;
  optimize::add(edge, -1, here);
  const double cross = here[0] * there[1] - here[1] * there[0];
  CHECK(near(shortest(2).length, std::abs(cross) / optimize::norm(edge)));
  CHECK(near(shortest(2).weights[3], 0));
  CHECK_THROWS_AS((void)optimize::minimum_norm_subgradient({}, 1), SolverFailure);
  // The second piece rises above the first along −x_1. Where it is gathered anew its distant cut is dropped.
  const auto offsets = model.drop_distant({0.5, 0, 0.5, 0}, 0.125);
  REQUIRE(offsets.size() == 1);
  CHECK(near(offsets[0][0], -0.125));
  CHECK(near(offsets[0][1], 0));
  CHECK(model.cuts().size() == 3);
}

TEST_CASE("a subspace that grows holds what it was given, in orthonormal coordinates", "[optimize]") {
  const Coupled problem;
  optimize::Span<Coupled> span(optimize::BundleOptions().dependent);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::vector<Point> given;
  std::vector<optimize::Coordinates> found;
  for (int k = 0; k < 6; ++k) {
    Point v{std::vector<double>(Coupled::n)};
    for (double& x : v.x)
      x = normal(random);
    if (k == 3) { // in the span already
      v = given[0];
      v.scale(-2);
      v.add(0.5, given[2]);
    } else if (k == 4) { // hardly out of it
      v.scale(1e-7);
      v.add(1, given[1]);
    }
    given.push_back(v);
    found.push_back(span.coordinates(problem, v));
    CHECK(span.dimension() == static_cast<std::size_t>(k < 3 ? k + 1 : k));
    CHECK(found.back().size() == span.dimension());
  }
  for (std::size_t i = 0; i < given.size(); ++i) {
    Point back = span.vector(found[i], given[0]);
    back.add(-1, given[i]);
    CHECK(optimize::norm(problem, back) < 1e-13 * optimize::norm(problem, given[i]));
    for (std::size_t j = 0; j <= i; ++j)
      CHECK(std::abs(optimize::dot(found[i], found[j]) - problem.inner(given[i], given[j])) < 1e-12);
  }
}

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
