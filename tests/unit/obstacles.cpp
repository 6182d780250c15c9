// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/error.h"
#include "contact/obstacle.h"
#include <algorithm>
#include <array>
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <vector>

using namespace signorini;
using Catch::Matchers::ContainsSubstring;

namespace {

using Point = std::array<double, 3>;
constexpr double diameter = 2.0; // of a body, m

contact::Obstacle made(const scene::Obstacle& shape, int dim = 3) {
  return {shape, "contact.obstacle", dim, diameter, false};
}

/// Points that lie all around the origin, half a metre to one and a half away.
std::vector<Point> points(int dim) {
  std::vector<Point> all;
  for (int i = 0; i < 40; ++i) {
    const double a = 0.7 * i, b = dim == 3 ? 0.4 * i : 0, r = 0.5 + 0.025 * i;
    all.push_back({r * std::cos(a) * std::cos(b), r * std::sin(a) * std::cos(b), r * std::sin(b)});
  }
  return all;
}

double distance(const Point& a, const Point& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

/// Whether an obstacle has the height and normal that a point expects.
template <class Expected>
void require_planes(const contact::Obstacle& obstacle, int dim, double tolerance, Expected&& expected) {
  for (const Point& x : points(dim)) {
    const contact::Obstacle::Plane plane = obstacle.at(x.data()), right = expected(x);
    CHECK(std::abs(plane.height - right.height) < tolerance);
    CHECK(distance(plane.normal, right.normal) < tolerance);
  }
}

} // namespace

TEST_CASE("a half-space of any orientation", "[contact]") {
  const double n = std::sqrt(0.09 + 0.04 + 1);
  require_planes(
      made(scene::HalfSpace{{"0.1", "-0.2", "0.3"}, {0.3, -0.2, 1}}), 3, 1e-15, [&](const Point& x) {
        return contact::Obstacle::Plane{{0.3 / n, -0.2 / n, 1 / n},
                                        (0.3 * (x[0] - 0.1) - 0.2 * (x[1] + 0.2) + x[2] - 0.3) / n};
      });
  // A normal of any length.
  require_planes(made(scene::HalfSpace{{"0", "0"}, {3e200, 4e200}}, 2), 2, 1e-15, [](const Point& x) {
    return contact::Obstacle::Plane{{0.6, 0.8, 0}, 0.6 * x[0] + 0.8 * x[1]};
  });
}

TEST_CASE("a half-space that moves", "[contact]") {
  const contact::Obstacle still = made(scene::HalfSpace{{"0", "-1 + 2"}, {0, 2}}, 2),
                          moving = made(scene::HalfSpace{{"t", "-1 + 2*t^2"}, {3, 4}}, 2);
  CHECK_FALSE(still.moves());
  REQUIRE(moving.moves());
  const Point x{0.3, -0.2, 0};
  const auto advance = [&](double t) {
    return moving.at(x.data()).height - moving.at(x.data(), moving.place(t)).height;
  };
  CHECK(advance(0) == 0);
  CHECK(std::abs(advance(0.5) - (0.6 * 0.5 + 0.8 * 0.5)) < 1e-15);
  CHECK_THROWS_AS(made(scene::HalfSpace{{"0", "1/(t - 1)"}, {0, 1}}, 2).place(1), UserError);
}

TEST_CASE("balls, cylinders and level sets move and grow", "[contact]") {
  constexpr double t = 0.5;
  const auto same = [&](const scene::Obstacle& moving, const scene::Obstacle& there, double tolerance) {
    const contact::Obstacle a = made(moving), b = made(there);
    CHECK(a.moves());
    CHECK_FALSE(b.moves());
    for (const Point& x : points(3)) {
      const contact::Obstacle::Plane p = a.at(x.data(), a.place(t)), q = b.at(x.data()),
                                     start = a.at(x.data());
      CHECK(std::abs(p.height - q.height) < tolerance);
      CHECK(distance(p.normal, q.normal) < tolerance);
      CHECK(std::abs(p.height - start.height) > 1e-3);
      CHECK((a.level(x.data(), a.place(t)) > 0) == (p.height > 0));
    }
  };
  for (const scene::Side side : {scene::Side::outside, scene::Side::inside}) {
    same(scene::Ball{{"t", 0.7, "0.2 - t^2"}, 0.4, side}, scene::Ball{{0.5, 0.7, -0.05}, 0.4, side}, 1e-15);
    same(scene::Ball{{0, 0, 0.1}, "0.4 + 0.2*t", side}, scene::Ball{{0, 0, 0.1}, 0.5, side}, 1e-15);
    same(scene::Cylinder{{"2*t", 0.03, 0}, {0, 1, 1}, "0.2 + 3*t^2", side},
         scene::Cylinder{{1, 0.03, 0}, {0, 1, 1}, 0.95, side}, 1e-15);
  }
  same(scene::SignedDistance{"3*(sqrt((x - t)^2 + (y - 0.7)^2 + z^2) - 0.4 - t)"},
       scene::Ball{{0.5, 0.7, 0}, 0.9, scene::Side::outside}, 1e-10);
  CHECK_THROWS_WITH(made(scene::Ball{{0, 0, 0}, "1 - t", scene::Side::outside}).place(1),
                    ContainsSubstring("radius: found 0 m at t = 1 s"));
}

TEST_CASE("balls and cylinders from outside and inside", "[contact]") {
  const Point c{0.2, -0.1, 0.15};
  for (const scene::Side side : {scene::Side::outside, scene::Side::inside}) {
    const double sign = side == scene::Side::inside ? -1 : 1;
    require_planes(made(scene::Ball{{c[0], c[1], c[2]}, 0.4, side}), 3, 1e-15, [&](const Point& x) {
      const double r = distance(x, c);
      return contact::Obstacle::Plane{
          {sign * (x[0] - c[0]) / r, sign * (x[1] - c[1]) / r, sign * (x[2] - c[2]) / r}, sign * (r - 0.4)};
    });
    const auto disc = [&](const Point& x) {
      const double r = std::hypot(x[0] - c[0], x[1] - c[1]);
      return contact::Obstacle::Plane{{sign * (x[0] - c[0]) / r, sign * (x[1] - c[1]) / r, 0},
                                      sign * (r - 0.4)};
    };
    require_planes(made(scene::Ball{{c[0], c[1]}, 0.4, side}, 2), 2, 1e-15, disc);
    require_planes(made(scene::Cylinder{{c[0], c[1]}, {}, 0.4, side}, 2), 2, 1e-15, disc);
    require_planes(made(scene::Cylinder{{c[0], c[1], 7}, {0, 0, -3}, 0.4, side}), 3, 1e-15, disc);
    // An axis along (1, 1, 0): distances from it by the cross product.
    require_planes(made(scene::Cylinder{{0, 0, 0}, {2, 2, 0}, 0.4, side}), 3, 1e-15, [&](const Point& x) {
      const double across = (x[0] - x[1]) / 2, r = std::hypot(std::numbers::sqrt2 * across, x[2]);
      return contact::Obstacle::Plane{{sign * across / r, -sign * across / r, sign * x[2] / r},
                                      sign * (r - 0.4)};
    });
  }
  const Point centre{1, 2, 0}, beside{1, 2, 0.5};
  CHECK_THROWS_WITH(made(scene::Ball{{1, 2, 0}, 0.5, scene::Side::inside}).at(centre.data()),
                    ContainsSubstring("(1, 2, 0)"));
  CHECK_THROWS_WITH(made(scene::Cylinder{{1, 2, 0}, {0, 0, 1}, 0.5, scene::Side::outside}).at(beside.data()),
                    ContainsSubstring("(1, 2, 0.5)"));
}

TEST_CASE("a signed distance is linearised by its derivatives", "[contact]") {
  // Differences of order 6 over 2e-4 m: rounding is 1e-16 (1 m / 2e-4 m) and more where the level set is
  // steep.
  constexpr double tolerance = 1e-11;
  require_planes(made(scene::SignedDistance{"sqrt(x^2 + y^2 + z^2) - 0.4"}), 3, tolerance,
                 [](const Point& x) {
                   const double r = distance(x, {});
                   return contact::Obstacle::Plane{{x[0] / r, x[1] / r, x[2] / r}, r - 0.4};
                 });
  // An ellipse by a level set that is no distance.
  require_planes(made(scene::SignedDistance{"5*(x^2/0.04 + y^2/0.01 - 1)"}, 2), 2, tolerance,
                 [](const Point& x) {
                   const Point g{10 * x[0] / 0.04, 10 * x[1] / 0.01, 0};
                   const double size = distance(g, {});
                   return contact::Obstacle::Plane{{g[0] / size, g[1] / size, 0},
                                                   5 * (x[0] * x[0] / 0.04 + x[1] * x[1] / 0.01 - 1) / size};
                 });
  // A corrugated floor with waves of a fortieth of the body.
  require_planes(made(scene::SignedDistance{"y + 0.01*sin(40*pi*x)"}, 2), 2, 1e-8, [](const Point& x) {
    const double k = 40 * std::numbers::pi, slope = 0.01 * k * std::cos(k * x[0]),
                 size = std::hypot(slope, 1);
    return contact::Obstacle::Plane{{slope / size, 1 / size, 0}, (x[1] + 0.01 * std::sin(k * x[0])) / size};
  });
  const Point x{0.5, 0, 0};
  for (const char* flat : {"1", "y^2", "0*x", "abs(y)"}) {
    CAPTURE(flat);
    CHECK_THROWS_WITH(made(scene::SignedDistance{flat}, 2).at(x.data()),
                      ContainsSubstring("the gradient of the expression is zero") &&
                          ContainsSubstring("(0.5, 0, 0)"));
  }
  for (const char* infinite : {"1/y", "sqrt(y - 1)", "sqrt(y)"}) { // the last one beside the node
    CAPTURE(infinite);
    CHECK_THROWS_WITH(made(scene::SignedDistance{infinite}, 2).at(x.data()), ContainsSubstring("x = 0.5"));
  }
}

TEST_CASE("heights and normals change with an obstacle's parameters as differences say", "[contact]") {
  constexpr double h = 1e-5, tolerance = 1e-7; // of second order
  const auto matches = [&](const auto& with, const scene::ObstacleRate& rate) {
    const contact::Obstacle before = made(with(-h)), here = made(with(0)), after = made(with(h));
    double largest = 0;
    for (const Point& x : points(3)) {
      const contact::Obstacle::Plane p = before.at(x.data()), q = after.at(x.data()),
                                     found = here.derivative(x.data(), here.place(0), rate);
      CHECK(std::abs(found.height - (q.height - p.height) / (2 * h)) < tolerance);
      for (std::size_t c = 0; c < 3; ++c)
        CHECK(std::abs(found.normal[c] - (q.normal[c] - p.normal[c]) / (2 * h)) < tolerance);
      largest = std::max({largest, std::abs(found.height), distance(found.normal, {})});
    }
    CHECK(largest > 0.1);
  };
  for (const scene::Side side : {scene::Side::outside, scene::Side::inside}) {
    const auto number = [](double x) { return fmt::format("{:.17g}", x); };
    const Point way{0.3, -0.2, 0.5};
    const auto moved = [&](double s) {
      return scene::Components{number(0.1 + way[0] * s), number(0.03 + way[1] * s), number(way[2] * s)};
    };
    matches([&](double s) { return scene::Obstacle(scene::Ball{moved(s), 0.4, side}); }, {.point = way});
    matches([&](double s) { return scene::Obstacle(scene::Ball{moved(0), number(0.4 + s), side}); },
            {.radius = 1});
    matches([&](double s) { return scene::Obstacle(scene::Cylinder{moved(s), {1, 2, 2}, 0.4, side}); },
            {.point = way});
    matches(
        [&](double s) {
          return scene::Obstacle(scene::Cylinder{moved(0), {1, 2, 2}, number(0.4 + s), side});
        },
        {.radius = 1});
  }
  matches(
      [](double s) {
        return scene::Obstacle(
            scene::HalfSpace{{"0.1", "0.2", fmt::format("{:.17g}", 0.3 + s)}, {0, 0.6, 0.8}});
      },
      {.point = {0, 0, 1}});
  matches(
      [](double s) {
        return scene::Obstacle(
            scene::HalfSpace{{"0.1", "0.2", "0.3"}, {-std::sin(s), 0.6 * std::cos(s), 0.8 * std::cos(s)}});
      },
      {.normal = {-1, 0, 0}});
}
