// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize_search.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>

using namespace signorini;
using namespace signorini::test;

namespace {

/// The same problem with controls c times as large and J k times.
template <class P>
struct InOtherUnits {
  using Vector = Point;
  using Compact = Point;
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
  static std::vector<double> pairings(std::span<const Point> a, std::span<const Point> b) {
    return P::pairings(a, b);
  }
  bool bounded() const { return given.bounded(); }
  void project(Point& u) const { bounds().project(u); }
  void zero_blocked(Point& v, const Point& u, const Point& d) const { bounds().zero_blocked(v, u, d); }
  [[nodiscard]] Bounded bounds() const { return {{}, c * given.lower, c * given.upper, {}, {}}; }
};

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

} // namespace

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
  const bool bounded = GENERATE(false, true);
  CAPTURE(bounded);
  const optimize::SearchUnits here = units(1, 1, bounded);
  CHECK(here.length > 0.5);
  CHECK(here.length < 10); // the minimiser is 5 away, the bounds 2.7
  for (const double c : {1e-9, 1e9})
    for (const double k : {1e-9, 1e9}) {
      const optimize::SearchUnits there = units(c, k, bounded);
      CHECK(std::abs(there.length / (c * here.length) - 1) < 1e-12);
      CHECK(std::abs(there.objective() / (k * here.objective()) - 1) < 1e-12);
      CHECK(std::abs(there.gradient() / (k / c * here.gradient()) - 1) < 1e-12);
    }
}
