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
  /// `key` names the obstacle in messages; `dim` and `diameter` (m) are the body's. Differences of a
  /// signed distance have a spacing of a small part of the diameter. Throws UserError.
  Obstacle(const scene::Obstacle& obstacle, std::string key, int dim, double diameter);

  /// The half-space for one point.
  struct Plane {
    std::array<double, 3> normal; ///< unit vector out of the obstacle
    double height;                ///< height of the point over the plane, negative inside the obstacle, m
  };

  /// Position and size of the obstacle at a time.
  struct Place {
    double t = 0;                  ///< s
    std::array<double, 3> point{}; ///< point of a plane or of a cylinder's axis, centre of a ball, m
    double radius = std::numeric_limits<double>::infinity(); ///< radius of a ball or cylinder, m
  };
  /// Position and size at time t. Throws UserError if they are not finite or a radius is not positive.
  [[nodiscard]] Place place(double t) const;

  /// The half-space for the point `x` (3). Throws UserError naming the point if no direction leads out of
  /// the obstacle or a signed distance is not finite.
  [[nodiscard]] Plane at(const double* x, const Place& place) const;
  /// The half-space for the point `x` (3) at t = 0. Throws as above.
  [[nodiscard]] Plane at(const double* x) const { return at(x, start_); }

  /// The derivative of at() by a parameter of a half-space, ball or cylinder.
  [[nodiscard]] Plane derivative(const double* x, const Place& place, const scene::ObstacleRate& rate) const;

  /// Level of the point `x` (3): positive outside of the obstacle, negative inside, greater farther out. For
  /// a signed distance it has the distance's own unit; for other shapes it is the height, m.
  [[nodiscard]] double level(const double* x, const Place& place) const;

  /// Whether the obstacle moves.
  [[nodiscard]] bool moves() const { return moves_; }

  /// Whether the body is inside of the obstacle, a ball or cylinder.
  [[nodiscard]] bool surrounds() const { return inside_; }

  /// Whether the surface may be curved, so that points that move along it leave the range of their
  /// half-space. Signed distances count as curved.
  [[nodiscard]] bool curved() const { return !std::holds_alternative<scene::HalfSpace>(shape_); }

  /// Two corners of the bounding box of the surface at a place, infinite along a cylinder's axis. Absent for
  /// planes, which have none, and for signed distances, where it is unknown.
  [[nodiscard]] std::optional<std::array<std::array<double, 3>, 2>> extent(const Place& place) const;

  /// Whether the surfaces at any two times differ by translation and scaling only; false for signed
  /// distances.
  [[nodiscard]] bool keeps_shape() const { return !distance_; }

  /// Position at the place `after` of the point `x` (3) of the surface at the place `before`. A plane moves
  /// along its normal. The obstacle must keep its shape.
  [[nodiscard]] std::array<double, 3> carried(const double* x, const Place& before, const Place& after) const;

  /// Vector from the centre or axis to the point `x` (3), m; zero for shapes without one.
  [[nodiscard]] std::array<double, 3> from_middle(const double* x, const Place& place) const;

private:
  /// The half-space of a sphere or cylinder with the body outside (or inside).
  [[nodiscard]] Plane round(const double* x, const Place& place) const;
  [[nodiscard]] Plane of_distance(const double* x, double t) const;

  scene::Obstacle shape_;
  std::string key_;
  std::size_t dim_;
  double diameter_;
  bool moves_, inside_ = false;       ///< inside_: the body is within a ball or cylinder
  std::array<double, 3> direction_{}; ///< unit vector: a half-space's normal, a cylinder's axis; zero without
  std::optional<scene::Field> point_, radius_; ///< fields that define the place
  std::optional<scene::Field> distance_;       ///< signed distance
  Place start_;
};

} // namespace signorini::contact
