// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/expression.h"
#include "scene/parameters.h"
#include <array>
#include <limits>
#include <optional>
#include <string>

namespace signorini::contact {

/// Rigid obstacle, linearised at each point of the undeformed body: for a point it is replaced by the
/// half-space that is tangent to the obstacle next to this point (docs/method.md section 2).
class Obstacle {
public:
  /// `key`: name of the obstacle in messages; `dim` and `diameter` (m): those of the body; `axisymmetric`:
  /// whether it is a body of revolution, for which a cylinder is around the axis. Signed distances are
  /// differentiated by finite differences, whose spacing is a small fraction of the diameter. Throws
  /// UserError.
  Obstacle(const scene::Obstacle& obstacle, std::string key, int dim, double diameter, bool axisymmetric);

  /// Half-space that replaces the obstacle for one point.
  struct Plane {
    std::array<double, 3> normal; ///< unit vector that points out of the obstacle
    double height;                ///< distance of the point from the plane, m; negative inside the obstacle
  };

  /// Position and size of the obstacle at one time.
  struct Place {
    double t = 0;                  ///< time, s
    std::array<double, 3> point{}; ///< point of a plane or of a cylinder's axis, centre of a ball, m
    double radius = std::numeric_limits<double>::infinity(); ///< radius of a ball or cylinder, m
  };
  /// Position and size of the obstacle at time t (s). Throws UserError if they are not finite or if the
  /// radius is not positive.
  [[nodiscard]] Place place(double t) const;

  /// Half-space for the point `x` (3, m). Throws UserError naming the point if the outward direction is
  /// undefined there or a signed distance is not finite.
  [[nodiscard]] Plane at(const double* x, const Place& place) const;
  /// Half-space for the point `x` (3, m) at t = 0. Throws UserError naming the point if the outward direction
  /// is undefined there or a signed distance is not finite.
  [[nodiscard]] Plane at(const double* x) const { return at(x, start_); }

  /// Derivative of at() with respect to a parameter of a half-space, ball or cylinder; zero for signed
  /// distances.
  [[nodiscard]] Plane derivative(const double* x, const Place& place, const scene::ObstacleRate& rate) const;

  /// Level of the point `x` (3, m): positive outside of the obstacle, negative inside, and increasing
  /// outwards. For a signed distance it is the value of the scene's expression, which need not be a length;
  /// for other shapes it is the distance from the surface, m.
  [[nodiscard]] double level(const double* x, const Place& place) const;

  /// Returns how deep the point `x` (3, m) is inside the obstacle, m; not positive outside, and 0 where a
  /// signed distance is undefined.
  [[nodiscard]] double depth(const double* x, const Place& place) const;

  /// Whether the obstacle moves.
  [[nodiscard]] bool moves() const { return moves_; }

  /// Whether the obstacle is the half section, x ≥ 0, of one of revolution.
  [[nodiscard]] bool axisymmetric() const { return axisymmetric_; }

  /// Whether the obstacle is a ball or cylinder with the body inside.
  [[nodiscard]] bool surrounds() const { return inside_; }

  /// Whether the surface may be curved. If so, a point that slides along it leaves the range in which its
  /// half-space is accurate. Signed distances count as curved.
  [[nodiscard]] bool curved() const { return !std::holds_alternative<scene::HalfSpace>(shape_); }

  /// Bounding box of the surface by two opposite corners, m; infinite along axes that are not perpendicular
  /// to a cylinder's axis. Absent for planes, which are unbounded, and for signed distances, whose extent is
  /// unknown.
  [[nodiscard]] std::optional<std::array<std::array<double, 3>, 2>> extent(const Place& place) const;

  /// Whether the surfaces at any two times differ only by translation and scaling; false for signed
  /// distances.
  [[nodiscard]] bool keeps_shape() const { return !distance_; }

  /// New position of a surface point when the obstacle moves from the place `before` to the place `after`.
  /// `x` (3, m): the point at `before`. Planes move along their normal. keeps_shape() must be true.
  [[nodiscard]] std::array<double, 3> carried(const double* x, const Place& before, const Place& after) const;

  /// Vector from the centre or axis of a ball or cylinder to the point `x` (3), m; zero for other shapes.
  [[nodiscard]] std::array<double, 3> from_middle(const double* x, const Place& place) const;

private:
  /// Half-space for a ball or cylinder.
  [[nodiscard]] Plane round(const double* x, const Place& place) const;
  [[nodiscard]] Plane of_distance(const double* x, double t) const;
  /// Value of the scene's expression for a signed distance; in axial symmetry at the radius |x|.
  [[nodiscard]] double distance(const double* x, double t) const;

  scene::Obstacle shape_;
  std::string key_;
  std::size_t dim_;
  double diameter_;
  bool axisymmetric_;
  bool moves_, inside_ = false;       ///< inside_: whether the body is inside a ball or cylinder
  std::array<double, 3> direction_{}; ///< unit normal of a half-space, unit axis of a cylinder; else zero
  std::optional<scene::Field> point_, radius_; ///< expressions for the members of Place
  std::optional<scene::Field> distance_;       ///< expression of a signed distance
  Place start_;
};

} // namespace signorini::contact
