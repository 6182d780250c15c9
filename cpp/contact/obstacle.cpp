// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/obstacle.h"
#include "base/error.h"
#include "base/overloads.h"
#include "base/point.h"
#include "base/text.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace signorini::contact {
namespace {

Point point(const double* x) { return {x[0], x[1], x[2]}; }

Point unit(const std::vector<double>& x) {
  Point p{};
  std::ranges::copy(x, p.begin());
  p = scaled(1 / std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])}),
             p); // so that the length does not over- or underflow
  return scaled(1 / length(p), p);
}

} // namespace

Obstacle::Obstacle(const scene::Obstacle& obstacle, std::string key, int dim, double diameter,
                   bool axisymmetric)
    : shape_(obstacle), key_(std::move(key)), dim_(static_cast<std::size_t>(dim)), diameter_(diameter),
      axisymmetric_(axisymmetric), moves_(scene::moves(obstacle)) {
  const auto round = [&](const scene::Components& middle, const char* name, const auto& shape) {
    point_.emplace(middle, fmt::format("{}.{}", key_, name), true);
    radius_.emplace(scene::Components{shape.radius}, key_ + ".radius", true);
    inside_ = shape.side == scene::Side::inside;
  };
  std::visit(Overloads{[&](const scene::HalfSpace& plane) {
                         direction_ = unit(plane.normal);
                         point_.emplace(plane.point, key_ + ".point", true);
                       },
                       [&](const scene::Ball& ball) { round(ball.center, "center", ball); },
                       [&](const scene::Cylinder& cylinder) {
                         round(cylinder.point, "point", cylinder);
                         if (axisymmetric)
                           direction_ = {0, 1, 0};
                         else if (!cylinder.axis.empty())
                           direction_ = unit(cylinder.axis);
                       },
                       [&](const scene::SignedDistance& level_set) {
                         distance_.emplace(scene::Components{level_set.distance}, key_ + ".distance", true);
                       }},
             shape_);
  start_ = place(0);
}

Obstacle::Place Obstacle::place(double t) const {
  Place place{.t = t};
  const Point origin{};
  if (point_)
    point_->evaluate(origin.data(), t, place.point.data());
  if (radius_) {
    radius_->evaluate(origin.data(), t, &place.radius);
    if (!(place.radius > 0))
      throw UserError(fmt::format("{}.radius: found {:.6g} m at t = {:.6g} s; a radius must stay above 0",
                                  key_, place.radius, t));
  }
  return place;
}

Obstacle::Plane Obstacle::at(const double* x, const Place& place) const {
  return std::visit(Overloads{[&](const scene::HalfSpace&) {
                                return Plane{direction_, dot(direction_, from(place.point, point(x)))};
                              },
                              [&](const scene::Ball&) { return round(x, place); },
                              [&](const scene::Cylinder&) { return round(x, place); },
                              [&](const scene::SignedDistance&) { return of_distance(x, place.t); }},
                    shape_);
}

Obstacle::Plane Obstacle::derivative(const double* x, const Place& place,
                                     const scene::ObstacleRate& rate) const {
  const auto round = [&] {
    const Point r = from_middle(x, place);
    const double distance = length(r), sign = inside_ ? -1 : 1;
    const Point drift = from(rate.point, scaled(dot(direction_, rate.point), direction_));
    const double away = dot(r, drift) / distance; // rate of the distance
    Point turn{};
    for (std::size_t c = 0; c < 3; ++c)
      turn[c] = sign / distance * (drift[c] - away / distance * r[c]);
    return Plane{turn, sign * (away - rate.radius)};
  };
  return std::visit(Overloads{[&](const scene::HalfSpace&) {
                                return Plane{rate.normal, dot(rate.normal, from(place.point, point(x))) -
                                                              dot(direction_, rate.point)};
                              },
                              [&](const scene::Ball&) { return round(); },
                              [&](const scene::Cylinder&) { return round(); },
                              [](const scene::SignedDistance&) { return Plane{}; }}, // without parameters
                    shape_);
}

double Obstacle::level(const double* x, const Place& place) const {
  const auto round = [&] { return (inside_ ? -1 : 1) * (length(from_middle(x, place)) - place.radius); };
  return std::visit(
      Overloads{[&](const scene::HalfSpace&) { return dot(direction_, from(place.point, point(x))); },
                [&](const scene::Ball&) { return round(); }, [&](const scene::Cylinder&) { return round(); },
                [&](const scene::SignedDistance&) { return distance(x, place.t); }},
      shape_);
}

double Obstacle::depth(const double* x, const Place& place) const {
  if (keeps_shape())
    return -level(x, place);
  try {
    return -at(x, place).height;
  } catch (const UserError&) { // the expression is not finite, or its gradient zero
    return 0;
  }
}

std::optional<std::array<std::array<double, 3>, 2>> Obstacle::extent(const Place& place) const {
  if (!radius_)
    return std::nullopt;
  std::array<Point, 2> corners{place.point, place.point};
  for (std::size_t c = 0; c < dim_; ++c) {
    const double reach = direction_[c] == 0 ? place.radius : std::numeric_limits<double>::infinity();
    corners[0][c] -= reach;
    corners[1][c] += reach;
  }
  return corners;
}

std::array<double, 3> Obstacle::carried(const double* x, const Place& before, const Place& after) const {
  if (radius_)
    return along(after.point, after.radius / before.radius, from(before.point, point(x)));
  return along(point(x), dot(direction_, from(before.point, after.point)), direction_);
}

std::array<double, 3> Obstacle::from_middle(const double* x, const Place& place) const {
  if (!radius_)
    return {};
  Point r = from(place.point, point(x));
  const double along = dot(direction_, r);
  for (std::size_t c = 0; c < 3; ++c)
    r[c] -= along * direction_[c];
  return r;
}

Obstacle::Plane Obstacle::round(const double* x, const Place& place) const {
  const Point r = from_middle(x, place);
  const double distance = length(r);
  if (!(distance > 1e-10 * place.radius)) // nearer to the middle, rounding determines the direction
    throw UserError(fmt::format("{}: the node at {} is at the centre or on the axis, where the outward "
                                "direction is undefined; move the body or the obstacle",
                                key_, point_text(x)));
  const double sign = inside_ ? -1 : 1;
  return {scaled(sign / distance, r), sign * (distance - place.radius)};
}

double Obstacle::distance(const double* x, double t) const {
  const Point at{axisymmetric_ ? std::abs(x[0]) : x[0], x[1], x[2]};
  double value = 0;
  distance_->evaluate(at.data(), t, &value);
  return value;
}

Obstacle::Plane Obstacle::of_distance(const double* x, double t) const {
  // Central differences of order 6. For an obstacle of length scale l their error is (h/l)^6, 1e-12 where l
  // is a hundredth of the body's diameter, and their rounding is 1e-16 (distance/h).
  const double h = 1e-4 * diameter_;
  constexpr std::array weights{45.0 / 60, -9.0 / 60, 1.0 / 60};
  const double value = distance(x, t);
  double largest = 0;
  Point gradient{};
  for (std::size_t c = 0; c < dim_; ++c)
    for (std::size_t k = 0; k < weights.size(); ++k) {
      double sides[2];
      for (int side : {0, 1}) {
        Point beside = point(x);
        beside[c] += (side == 0 ? -1.0 : 1.0) * static_cast<double>(k + 1) * h;
        try {
          sides[side] = distance(beside.data(), t);
        } catch (const UserError& error) {
          throw UserError(fmt::format("{}, also in the neighbourhood of the node at {}, where the expression "
                                      "is differentiated",
                                      error.what(), point_text(x)));
        }
        largest = std::max(largest, std::abs(sides[side] - value));
      }
      gradient[c] += weights[k] * (sides[1] - sides[0]) / h;
    }
  const double size = length(gradient);
  // Where the gradient vanishes, one-sided differences are of second order in h, and their sum is rounding.
  if (!(size * h > 1e-6 * largest))
    throw UserError(fmt::format("{}.distance: the gradient of the expression is zero at the node at {}{}; "
                                "the expression must increase away from the obstacle",
                                key_, point_text(x), moves_ ? fmt::format(", t = {:.6g} s", t) : ""));
  return {scaled(1 / size, gradient), value / size};
}

} // namespace signorini::contact
