// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/obstacle_surface.h"
#include "base/point.h"
#include <algorithm>
#include <array>
#include <catch2/catch_approx.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

using namespace signorini;
using Catch::Approx;

namespace {

contact::Obstacle made(const scene::Obstacle& shape, int dim) {
  return {shape, "contact.obstacle", dim, 2.0, false};
}

Point at(const contact::ObstacleSurface& surface, int dim, std::int64_t point) {
  Point x{};
  std::copy_n(&surface.points[static_cast<std::size_t>(dim * point)], dim, x.begin());
  return x;
}

/// Twice the vector area of a facet in space, the turned side in the plane.
Point normal(const contact::ObstacleSurface& surface, int dim, std::size_t facet) {
  std::array<Point, 3> x{};
  for (int i = 0; i < dim; ++i)
    x[static_cast<std::size_t>(i)] =
        at(surface, dim, surface.facets[facet * static_cast<std::size_t>(dim) + static_cast<std::size_t>(i)]);
  const Point side = from(x[0], x[1]);
  return dim == 2 ? Point{-side[1], side[0], 0} : cross(side, from(x[0], x[2]));
}

struct Measures {
  double size = 0;    ///< length or area
  double off = 0;     ///< largest height of a point
  double inwards = 0; ///< the worst cosine between a facet's normal and the obstacle's
  bool closed = true; ///< whether every side belongs to two facets
};

Measures measured(const contact::Obstacle& obstacle, const contact::Obstacle::Place& place,
                  const contact::ObstacleSurface& surface, int dim) {
  Measures found{.inwards = 1};
  std::map<std::pair<std::int64_t, std::int64_t>, int> sides;
  const std::size_t facets = surface.facets.size() / static_cast<std::size_t>(dim);
  for (std::size_t f = 0; f < facets; ++f) {
    const Point n = normal(surface, dim, f);
    const double size = length(n);
    found.size += dim == 2 ? size : size / 2;
    Point middle{};
    for (int i = 0; i < dim; ++i) {
      const std::int64_t
          a = surface.facets[f * static_cast<std::size_t>(dim) + static_cast<std::size_t>(i)],
          b = surface.facets[f * static_cast<std::size_t>(dim) + static_cast<std::size_t>((i + 1) % dim)];
      if (dim == 2)
        ++sides[{a, a}];
      else
        ++sides[{std::min(a, b), std::max(a, b)}];
      const Point x = at(surface, dim, a);
      found.off = std::max(found.off, std::abs(obstacle.at(x.data(), place).height));
      for (std::size_t c = 0; c < 3; ++c)
        middle[c] += x[c] / dim;
    }
    if (size > 1e-9) {
      const Point out = obstacle.at(middle.data(), place).normal;
      found.inwards = std::min(found.inwards, dot(n, out) / size);
    }
  }
  found.closed = std::ranges::all_of(sides, [](const auto& side) { return side.second == 2; });
  return found;
}

const contact::Box around{{-2, -2, -2}, {2, 2, 2}};

contact::Box of(int dim) {
  contact::Box box = around;
  if (dim == 2)
    box.low[2] = box.high[2] = 0;
  return box;
}

} // namespace

TEST_CASE("the surface of a ball is closed and turned outwards, its area converges", "[contact]") {
  const auto side = GENERATE(scene::Side::outside, scene::Side::inside);
  const int dim = GENERATE(2, 3);
  const std::vector<scene::Expression> centre =
      dim == 2 ? std::vector<scene::Expression>{0.1, 0.2} : std::vector<scene::Expression>{0.1, 0.2, -0.3};
  const contact::Obstacle ball = made(scene::Ball{centre, 0.5, side}, dim);
  constexpr double exact = std::numbers::pi; // 2πr as 4πr² of r = 1/2
  std::vector<double> errors;
  for (const int cells : {16, 64}) {
    CAPTURE(cells);
    const auto surface = surface_within(ball, ball.place(0), dim, of(dim), cells);
    const Measures found = measured(ball, ball.place(0), surface, dim);
    CHECK(surface.whole);
    CHECK(found.closed);
    CHECK(found.off < 1e-12);   // moved onto it
    CHECK(found.inwards > 0.8); // slivers turn a little
    errors.push_back(std::abs(found.size - exact) / exact);
  }
  CHECK(errors[1] < 0.02);
  CHECK(std::log2(errors[0] / errors[1]) / 2 == Approx(2).margin(0.3));
}

TEST_CASE("a part of a large ball, and none where it is out of sight", "[contact]") {
  const contact::Obstacle ball = made(scene::Ball{{0.0, -50.0, 0.0}, 50.0, scene::Side::outside}, 3);
  const auto surface = surface_within(ball, ball.place(0), 3, around, 20);
  const Measures found = measured(ball, ball.place(0), surface, 3);
  CHECK_FALSE(surface.whole);
  CHECK_FALSE(found.closed);
  CHECK(found.size == Approx(16).epsilon(0.01)); // nearly flat
  CHECK(found.off < 1e-9);
  const contact::Box far{{10, 10, 10}, {12, 12, 12}};
  CHECK(surface_within(ball, ball.place(0), 3, far, 20).facets.empty());
}

TEST_CASE("planes reach as far as the box, cylinders to its ends", "[contact]") {
  const contact::Obstacle line = made(scene::HalfSpace{{0.1, 0.2}, {0.3, -2}}, 2);
  const auto segment = surface_within(line, line.place(0), 2, of(2), 10);
  const Measures straight = measured(line, line.place(0), segment, 2);
  CHECK(segment.facets.size() == 2);
  CHECK_FALSE(segment.whole);
  CHECK(straight.off < 1e-14);
  CHECK(straight.inwards == Approx(1));
  const double n = std::hypot(0.3, 2); // the box is 4 (|n_x| + |n_y|)/|n| wide along the line
  CHECK(straight.size == Approx(4 * 2.3 / n));

  const contact::Obstacle plane = made(scene::HalfSpace{{0.1, 0.2, 0.0}, {0, 0, -2}}, 3);
  const Measures flat =
      measured(plane, plane.place(0), surface_within(plane, plane.place(0), 3, around, 10), 3);
  CHECK(flat.size == Approx(16));
  CHECK(flat.inwards == Approx(1));

  const contact::Obstacle rod =
      made(scene::Cylinder{{0.0, 0.0, 0.0}, {0, 0, 3}, 0.5, scene::Side::outside}, 3);
  const auto tube = surface_within(rod, rod.place(0), 3, around, 40);
  CHECK_FALSE(tube.whole);
  CHECK(measured(rod, rod.place(0), tube, 3).size == Approx(4 * std::numbers::pi).epsilon(0.02));
}

TEST_CASE("level sets where they are negative, with holes where they have no value", "[contact]") {
  const contact::Obstacle wave = made(scene::SignedDistance{"3*(y - 0.2*sin(2*x))"}, 2);
  const auto surface = surface_within(wave, wave.place(0), 2, of(2), 100);
  double length = 0;
  constexpr int parts = 4000;
  for (int i = 0; i < parts; ++i) {
    const double x = -2 + 4 * (i + 0.5) / parts;
    length += 4.0 / parts * std::hypot(1, 0.4 * std::cos(2 * x));
  }
  const Measures found = measured(wave, wave.place(0), surface, 2);
  CHECK(found.size == Approx(length).epsilon(1e-3));
  CHECK(found.off < 1e-4);
  CHECK(found.inwards > 0.99);
  const contact::Obstacle half = made(scene::SignedDistance{"y + 0*sqrt(1.001 - x)"}, 2);
  CHECK(measured(half, half.place(0), surface_within(half, half.place(0), 2, of(2), 100), 2).size ==
        Approx(3).margin(0.05));
}

TEST_CASE("points of a surface are carried along with it", "[contact]") {
  const contact::Obstacle ball = made(scene::Ball{{"t", 0.0, 0.0}, "0.5 + t", scene::Side::outside}, 3),
                          plane = made(scene::HalfSpace{{"5*t", "2*t", 0.0}, {0, 1, 0}}, 3);
  for (const contact::Obstacle* each : {&ball, &plane}) {
    const contact::Obstacle& obstacle = *each;
    const contact::Obstacle::Place start = obstacle.place(0), later = obstacle.place(0.3);
    const auto surface = surface_within(obstacle, start, 3, around, 12);
    REQUIRE(!surface.points.empty());
    for (std::int64_t i = 0; 3 * static_cast<std::size_t>(i) < surface.points.size(); ++i) {
      const Point x = at(surface, 3, i), moved = obstacle.carried(x.data(), start, later),
                  back = obstacle.carried(moved.data(), later, start);
      CHECK(std::abs(obstacle.at(moved.data(), later).height) < 1e-12);
      for (std::size_t c = 0; c < 3; ++c)
        CHECK(back[c] == Approx(x[c]).margin(1e-14));
    }
  }
  const Point origin{}, moved = plane.carried(origin.data(), plane.place(0), plane.place(0.3));
  CHECK(moved[0] == 0); // along the normal alone
  CHECK(moved[1] == Approx(0.6));
  CHECK_FALSE(made(scene::SignedDistance{"y - t"}, 2).keeps_shape());
}
