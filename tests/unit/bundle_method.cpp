// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize_search.h"
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>

using namespace signorini;
using namespace signorini::test;

namespace {

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
  CHECK(certificate.radius <= 4 * optimize::Options::ball(tolerance)); // no step here is as long as four
  Point sum = u;
  sum.scale(0);
  double whole = 0;
  for (std::size_t i = 0; i < certificate.points.size(); ++i) {
    Point offset = *certificate.points[i], inside = offset;
    offset.add(-1, u);
    problem.project(inside);
    CHECK(inside.x == certificate.points[i]->x);
    CHECK(std::sqrt(problem.inner(offset, offset)) <= certificate.radius * (1 + 1e-9));
    CHECK(certificate.weights[i] > 0);
    whole += certificate.weights[i];
    sum.add(certificate.weights[i], optimize::evaluated(problem, *certificate.points[i])->g);
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
        CHECK(record.rows.size() < 400); // 30 to 280, depending on the pieces met and on the rounding of BLAS
        const auto at_bounds = std::ranges::count_if(
            problem.current.x, [&](double x) { return x == problem.lower || x == problem.upper; });
        held += at_bounds > 0;
      }
  CHECK(held >= 3); // of 6
}

TEST_CASE("a looser tolerance is met no later, by gradients of the last iterates", "[optimize]") {
  std::size_t earlier = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    std::size_t last = 0;
    for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6}) {
      INFO("seed " << seed << ", tolerance " << tolerance);
      Pieces problem(seed, 1e300);
      Record record;
      const auto ending = search(Method::lbfgs, problem, Point{std::vector<double>(problem.n, 0.3)},
                                 {.max_iterations = 500, .tolerance = tolerance}, record);
      require_certified(problem, ending, record, tolerance);
      CHECK(record.rows.size() >= last);
      earlier += record.rows.size() > last;
      last = record.rows.size();
    }
  }
  CHECK(earlier >= 12); // of 24: tolerances do tell
}

TEST_CASE("on a smooth function iterates around the minimiser certify no kink", "[optimize]") {
  const double tolerance = GENERATE(1e-2, 1e-3, 1e-4);
  CAPTURE(tolerance);
  Quadratic problem;
  problem.lower = -1e300, problem.upper = 1e300;
  Record record;
  CHECK(minimise(Method::lbfgs, problem, start, {.tolerance = tolerance}, record) ==
        optimize::Stop::gradient_tolerance);
}

TEST_CASE("rounding of blocked values neither ends a search nor keeps it for ever", "[optimize]") {
  // One machine's rounding meets it in one of these, another's in others.
  int blocked = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    INFO("seed " << seed);
    Pieces problem(seed, 0.35);
    Record record;
    const auto ending = search(Method::newton_cg, problem, Point{std::vector<double>(problem.n, 0.3)},
                               {.max_iterations = 500, .tolerance = 1e-7}, record);
    CHECK(ending.stop == optimize::Stop::kink);
    blocked += std::ranges::any_of(problem.current.x,
                                   [&](double x) { return x == problem.lower || x == problem.upper; });
  }
  CHECK(blocked >= 30);
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

TEST_CASE("a subspace restricted to a part of it holds that part, and grows again", "[optimize]") {
  using optimize::Coordinates;
  const Coupled problem;
  optimize::Span<Coupled> span(optimize::BundleOptions().dependent);
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  const auto any = [&](const Point* near) {
    Point v{std::vector<double>(Coupled::n)};
    for (double& x : v.x)
      x = normal(random);
    if (near) {
      v.scale(0.1);
      v.add(1, *near);
    }
    return v;
  };
  std::vector<Point> given;
  std::vector<Coordinates> found;
  for (int k = 0; k < 12; ++k) {
    given.push_back(any(k % 3 == 0 ? nullptr : &given.back()));
    found.push_back(span.coordinates(problem, given.back()));
  }
  REQUIRE(span.dimension() == 12);
  optimize::Orthonormal part(optimize::BundleOptions().dependent);
  REQUIRE(part.take({&found[7], &found[2]}, 5));
  REQUIRE(part.take({&found[11], &found[2], &found[4]}, 5));
  REQUIRE(part.vectors().size() == 4); // one was there
  CHECK_FALSE(part.take({&found[0], &found[1]}, 5));
  CHECK(part.vectors().size() == 4); // all or nothing
  span.restrict(part.vectors());
  REQUIRE(span.dimension() == 4);
  const auto require_held = [&](const Coordinates& x, const Point& v) {
    Point back = span.vector(x, v);
    back.add(-1, v);
    CHECK(optimize::norm(problem, back) < 1e-12 * optimize::norm(problem, v));
    CHECK(std::abs(optimize::norm(x) - optimize::norm(problem, v)) < 1e-12 * optimize::norm(problem, v));
  };
  for (const std::size_t k : {2u, 4u, 7u, 11u})
    require_held(part.of(found[k]), given[k]);
  const Point again = given[7], further = given[5];
  require_held(span.coordinates(problem, again), again);
  CHECK(span.dimension() == 4);
  require_held(span.coordinates(problem, further), further);
  CHECK(span.dimension() == 5);
}

TEST_CASE("with room for few vectors a search ends with a certificate too", "[optimize]") {
  int otherwise = 0;
  for (Method method : {Method::lbfgs, Method::newton_cg})
    for (const bool bounded : {false, true})
      for (unsigned seed = 1; seed <= 3; ++seed) {
        INFO("method " << static_cast<int>(method) << ", seed " << seed << (bounded ? ", bounds" : ""));
        const optimize::Options usual{.max_iterations = 500, .tolerance = 1e-7};
        optimize::Options little = usual;
        little.vectors = 16;
        std::vector<std::size_t> iterations;
        std::vector<double> values;
        for (const optimize::Options& options : {usual, little}) {
          Pieces problem(seed, bounded ? 0.35 : 1e300);
          Record record;
          const auto ending =
              search(method, problem, Point{std::vector<double>(problem.n, 0.3)}, options, record);
          require_certified(problem, ending, record, options.tolerance);
          iterations.push_back(record.rows.size());
          values.push_back(record.rows.back().objective);
        }
        otherwise += iterations[0] != iterations[1];
        CHECK(std::abs(values[1] - values[0]) < 1e-6); // both are the minimum
      }
  CHECK(otherwise > 0); // room was what it lacked
}

TEST_CASE("a direction takes as many Hessian products as it may, however often values are blocked",
          "[optimize]") {
  // The Hessian of each product is eight times that of the last, so that no product tells the curvature. That
  // of the first couples x, at its bound, to y: the second direction leads out, and x is blocked.
  struct Stiffening : Bounded {
    std::vector<Point> directions;
    Stiffening() { w = {1, 1}, lower = -1, upper = 1e300; }
    double value(const Point& u) {
      trial = u;
      return u.x[1] - u.x[0] / 8;
    }
    static Point trial_gradient() { return {{-0.125, 1}}; }
    Point hessian_product(const Point& d) {
      const double c = std::ldexp(1, 3 * static_cast<int>(directions.size()));
      directions.push_back(d);
      return {{c * (5 * d.x[0] - 2 * d.x[1]), c * (2 * d.x[1] - 2 * d.x[0])}};
    }
  };
  for (const int most : {1, 2, 3, 10}) {
    INFO("of " << most);
    Stiffening problem;
    const Point corner{{-1, 0}};
    optimize::Options options;
    options.bundle.products = most;
    optimize::BundleMethod<Stiffening> bundle(
        options, problem, {corner, problem.value(corner), Stiffening::trial_gradient()}, 1);
    CHECK_FALSE(
        bundle.round(problem, {corner, problem.value(corner), Stiffening::trial_gradient()}, 1e-6).found);
    REQUIRE(problem.directions.size() == static_cast<std::size_t>(most));
    for (std::size_t i = 0; i < problem.directions.size(); ++i)
      CHECK((problem.directions[i].x[0] == 0) == (i > 0));
  }
}

TEST_CASE("a step of the bundle method that ends exactly on a bound says so", "[optimize]") {
  // −x + x²/2 − x³/6 from 0: the model's minimiser is 1, the bound, where J still descends. The method cannot
  // block there what was free where it started.
  struct OntoBound : Bounded {
    OntoBound() { w = {1}, lower = -1e300, upper = 1; }
    double value(const Point& u) {
      trial = u;
      const double x = u.x[0];
      return -x + x * x / 2 - x * x * x / 6;
    }
    Point trial_gradient() {
      const double x = trial.x[0];
      return {{-1 + x - x * x / 2}};
    }
    Point hessian_product(const Point& d) { return {{(1 - current.x[0]) * d.x[0]}}; }
  };
  OntoBound problem;
  const Point from{{0}};
  const double J = problem.value(from);
  problem.accept();
  const optimize::Iterate<OntoBound> at{from, J, problem.trial_gradient()};
  optimize::BundleMethod<OntoBound> bundle(optimize::Options(), problem, at, 1);
  const auto step = bundle.round(problem, at, 1e-6);
  REQUIRE(step.found);
  REQUIRE(step.found->u.x[0] == 1);
  CHECK(step.at_other_bounds);
}
