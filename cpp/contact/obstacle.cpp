#include "contact/obstacle.h"
#include "base/error.h"
#include "base/text.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace signorini::contact {
namespace {

using Point = std::array<double, 3>;

Point padded(const std::vector<double>& x) {
  Point p{};
  std::ranges::copy(x, p.begin());
  return p;
}

double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

double length(const Point& a) { return std::hypot(a[0], a[1], a[2]); }

Point scaled(double s, const Point& a) { return {s * a[0], s * a[1], s * a[2]}; }

Point from(const Point& a, const double* x) { return {x[0] - a[0], x[1] - a[1], x[2] - a[2]}; }

Point unit(const std::vector<double>& x) {
  Point p = padded(x);
  p = scaled(1 / std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])}),
             p); // so that the length does not over- or underflow
  return scaled(1 / length(p), p);
}

} // namespace

Obstacle::Obstacle(const scene::Obstacle& obstacle, std::string key, int dim, double diameter)
    : shape_(obstacle), key_(std::move(key)), dim_(static_cast<std::size_t>(dim)), diameter_(diameter) {
  if (const auto* half_space = std::get_if<scene::HalfSpace>(&shape_)) {
    normal_ = unit(half_space->normal);
    scene::Field point(half_space->point, key_ + ".point", true);
    const Point origin{};
    point.evaluate(origin.data(), 0, start_.data());
    if (point.depends_on_time())
      motion_ = std::move(point);
  }
  if (const auto* level_set = std::get_if<scene::SignedDistance>(&shape_))
    distance_.emplace(scene::Components{level_set->distance}, key_ + ".distance", false);
}

Obstacle::Plane Obstacle::at(const double* x) const {
  return std::visit([&](const auto& shape) { return plane(shape, x); }, shape_);
}

double Obstacle::advance(double t) const {
  const Point origin{};
  Point now{};
  motion_->evaluate(origin.data(), t, now.data());
  return dot(normal_, from(start_, now.data()));
}

double Obstacle::radius() const {
  if (const auto* ball = std::get_if<scene::Ball>(&shape_))
    return ball->radius;
  if (const auto* cylinder = std::get_if<scene::Cylinder>(&shape_))
    return cylinder->radius;
  return std::numeric_limits<double>::infinity();
}

Obstacle::Plane Obstacle::plane(const scene::HalfSpace&, const double* x) const {
  return {normal_, dot(normal_, from(start_, x))};
}

Obstacle::Plane Obstacle::plane(const scene::Ball& ball, const double* x) const {
  return round(from(padded(ball.center), x), ball.radius, ball.side, x);
}

Obstacle::Plane Obstacle::plane(const scene::Cylinder& cylinder, const double* x) const {
  Point r = from(padded(cylinder.point), x);
  if (!cylinder.axis.empty()) {
    const Point axis = unit(cylinder.axis);
    const double along = dot(axis, r);
    for (std::size_t c = 0; c < 3; ++c)
      r[c] -= along * axis[c];
  }
  return round(r, cylinder.radius, cylinder.side, x);
}

Obstacle::Plane Obstacle::round(const Point& r, double radius, scene::Side side, const double* x) const {
  const double distance = length(r);
  if (!(distance > 1e-10 * radius)) // nearer to the middle the direction is rounding
    throw UserError(
        fmt::format("{}: the node at {} is at the middle, from where no one direction leads out of "
                    "the obstacle, allowed are nodes off the centre or axis",
                    key_, point_text(x)));
  const double sign = side == scene::Side::inside ? -1 : 1;
  return {scaled(sign / distance, r), sign * (distance - radius)};
}

Obstacle::Plane Obstacle::plane(const scene::SignedDistance&, const double* x) const {
  // Central differences of order 6. For an obstacle of length scale l their error is (h/l)^6, 1e-12 where l
  // is a hundredth of the body's diameter, and their rounding is 1e-16 (distance/h).
  const double h = 1e-4 * diameter_;
  constexpr std::array weights{45.0 / 60, -9.0 / 60, 1.0 / 60};
  double value = 0, largest = 0;
  distance_->evaluate(x, 0, &value);
  Point gradient{};
  for (std::size_t c = 0; c < dim_; ++c)
    for (std::size_t k = 0; k < weights.size(); ++k) {
      double sides[2];
      for (int side : {0, 1}) {
        Point beside{x[0], x[1], x[2]};
        beside[c] += (side == 0 ? -1.0 : 1.0) * static_cast<double>(k + 1) * h;
        try {
          distance_->evaluate(beside.data(), 0, &sides[side]);
        } catch (const UserError& error) {
          throw UserError(fmt::format("{}, and around the node at {}, where its derivatives are wanted",
                                      error.what(), point_text(x)));
        }
        largest = std::max(largest, std::abs(sides[side] - value));
      }
      gradient[c] += weights[k] * (sides[1] - sides[0]) / h;
    }
  const double size = length(gradient);
  // Where the gradient vanishes, one-sided differences are of second order in h, and their sum is rounding.
  if (!(size * h > 1e-6 * largest))
    throw UserError(fmt::format(
        "{}.distance: the expression has no slope at the node at {}, allowed are expressions that grow "
        "where they lead out of the obstacle",
        key_, point_text(x)));
  return {scaled(1 / size, gradient), value / size};
}

} // namespace signorini::contact
