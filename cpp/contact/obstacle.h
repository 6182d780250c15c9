// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/expression.h"
#include "scene/parameters.h"
#include <array>
#include <limits>
#include <optional>
#include <string>

namespace signorini::contact {

/// A rigid obstacle, linearised for each point of the undeformed body: the half-space that is tangent to the
/// obstacle next to the point (docs/method.md section 2).
class Obstacle {
public:
  /// `key` names the obstacle in messages; `dim` and `diameter` (m) are the body's: the spacing of the
  /// differences of a signed distance is a small part of it. Throws UserError.
  Obstacle(const scene::Obstacle& obstacle, std::string key, int dim, double diameter);

  /// The half-space for one point.
  struct Plane {
    std::array<double, 3> normal; ///< unit vector out of the obstacle
    double height;                ///< of the point over the plane, negative inside the obstacle, m
  };

  /// Where and how large the obstacle is at a time.
  struct Place {
    double t = 0;                  ///< s
    std::array<double, 3> point{}; ///< of a plane; of a ball its centre, of a cylinder a point of its axis, m
    double radius = std::numeric_limits<double>::infinity(); ///< of a ball or cylinder, m
  };
  /// At time t. Throws UserError if it is not finite or a radius not positive.
  [[nodiscard]] Place place(double t) const;

  /// The half-space for the point `x` (3). Throws UserError naming the point where no direction leads out of
  /// the obstacle, or a signed distance is not finite.
  [[nodiscard]] Plane at(const double* x, const Place& place) const;
  /// The same at t = 0.
  [[nodiscard]] Plane at(const double* x) const { return at(x, start_); }

  /// The derivative of at() by a parameter of a half-space, ball or cylinder.
  [[nodiscard]] Plane derivative(const double* x, const Place& place, const scene::ObstacleRate& rate) const;

  /// A function of the point `x` (3) that is positive outside of the obstacle, negative inside and the
  /// greater the farther: of a signed distance in its own unit, else the height.
  [[nodiscard]] double level(const double* x, const Place& place) const;

  /// Whether the obstacle moves.
  [[nodiscard]] bool moves() const { return moves_; }

  /// Whether the body is inside of it, a ball or cylinder.
  [[nodiscard]] bool surrounds() const { return inside_; }

  /// Whether the surface may be curved, so that points that move along it leave the range of their
  /// half-space. Signed distances count as curved.
  [[nodiscard]] bool curved() const { return !std::holds_alternative<scene::HalfSpace>(shape_); }

  /// Two corners of the box that holds the surface at a place, infinite along a cylinder's axis; absent for
  /// planes, which no box holds, and for signed distances, of which it is unknown.
  [[nodiscard]] std::optional<std::array<std::array<double, 3>, 2>> extent(const Place& place) const;

  /// Whether the surface at any time is that of another time moved and scaled, as of all but signed
  /// distances.
  [[nodiscard]] bool keeps_shape() const { return !distance_; }

  /// Where the point `x` (3) of the surface at one place is at another one; a plane moves along its normal.
  /// The obstacle must keep its shape.
  [[nodiscard]] std::array<double, 3> carried(const double* x, const Place& before, const Place& after) const;

  /// From the centre or axis to the point `x` (3), m; zero for shapes without one.
  [[nodiscard]] std::array<double, 3> from_middle(const double* x, const Place& place) const;

private:
  /// The half-space of a sphere or cylinder with the body outside (or inside).
  [[nodiscard]] Plane round(const double* x, const Place& place) const;
  [[nodiscard]] Plane of_distance(const double* x, double t) const;

  scene::Obstacle shape_;
  std::string key_;
  std::size_t dim_;
  double diameter_;
  bool moves_, inside_ = false;       ///< the body within a ball or cylinder
  std::array<double, 3> direction_{}; ///< unit vector: a half-space's normal, a cylinder's axis; zero without
  std::optional<scene::Field> point_, radius_; ///< of the place
  std::optional<scene::Field> distance_;       ///< signed distance
  Place start_;
};

} // namespace signorini::contact
