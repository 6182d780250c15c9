#pragma once
#include "scene/expression.h"
#include "scene/scene.h"
#include <array>
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

  /// The half-space at t = 0 for the point `x` (3). Throws UserError naming the point where no direction
  /// leads out of the obstacle, or a signed distance is not finite.
  [[nodiscard]] Plane at(const double* x) const;

  /// Whether the obstacle moves.
  [[nodiscard]] bool moves() const { return motion_.has_value(); }

  /// Whether the surface may be curved, so that points that move along it leave the range of their
  /// half-space. Signed distances count as curved.
  [[nodiscard]] bool curved() const { return !std::holds_alternative<scene::HalfSpace>(shape_); }
  /// Radius of a ball or cylinder, m; infinite for other shapes.
  [[nodiscard]] double radius() const;

  /// How far a moving obstacle has advanced along its normal by time t, m: all heights are less than at t = 0
  /// by this. Only where moves(). Throws UserError if its position is not finite.
  [[nodiscard]] double advance(double t) const;

private:
  [[nodiscard]] Plane plane(const scene::HalfSpace& obstacle, const double* x) const;
  [[nodiscard]] Plane plane(const scene::Ball& obstacle, const double* x) const;
  [[nodiscard]] Plane plane(const scene::Cylinder& obstacle, const double* x) const;
  [[nodiscard]] Plane plane(const scene::SignedDistance& obstacle, const double* x) const;
  /// The half-space of a sphere or cylinder with the body outside (or inside); `r` from the centre or axis to
  /// the point.
  [[nodiscard]] Plane round(const std::array<double, 3>& r, double radius, scene::Side side,
                            const double* x) const;

  scene::Obstacle shape_;
  std::string key_;
  std::size_t dim_;
  double diameter_;
  std::array<double, 3> normal_{}, start_{}; ///< of a half-space: unit normal, and its point at t = 0
  std::optional<scene::Field> motion_;       ///< point of a half-space that moves
  std::optional<scene::Field> distance_;     ///< signed distance
};

} // namespace signorini::contact
