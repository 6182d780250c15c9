#pragma once
#include "scene/expression.h"
#include "scene/scene.h"
#include <array>
#include <optional>
#include <string>

namespace signorini::contact {

/// A rigid obstacle as points of the undeformed body see it: linearised, by the half-space that touches it
/// next to them.
class Obstacle {
public:
  /// `key` names the obstacle in messages; `dim` and `diameter` (m) are the body's: derivatives of a signed
  /// distance are taken on a small part of it. Throws UserError.
  Obstacle(const scene::Obstacle& obstacle, std::string key, int dim, double diameter);

  /// The linearised obstacle of one point.
  struct Plane {
    std::array<double, 3> normal; ///< unit vector out of the obstacle
    double height;                ///< of the point over the plane, negative inside the obstacle, m
  };

  /// The obstacle at t = 0 as `x` (3) sees it. Throws UserError naming the point where no direction leads out
  /// of the obstacle, or a signed distance is not finite.
  [[nodiscard]] Plane at(const double* x) const;

  /// Whether the obstacle moves.
  [[nodiscard]] bool moves() const { return motion_.has_value(); }

  /// Whether its surface bends, so that points that move along it leave the half-space that touched it next to
  /// them.
  [[nodiscard]] bool curved() const { return !std::holds_alternative<scene::HalfSpace>(shape_); }
  /// Of a ball or cylinder, m; infinite for other shapes.
  [[nodiscard]] double radius() const;

  /// How far an obstacle that moves has come along its normal by time t, by which all heights are less than
  /// at t = 0, m. Throws UserError if its place is not finite.
  [[nodiscard]] double advance(double t) const;

private:
  [[nodiscard]] Plane plane(const scene::HalfSpace& obstacle, const double* x) const;
  [[nodiscard]] Plane plane(const scene::Ball& obstacle, const double* x) const;
  [[nodiscard]] Plane plane(const scene::Cylinder& obstacle, const double* x) const;
  [[nodiscard]] Plane plane(const scene::SignedDistance& obstacle, const double* x) const;
  /// With the body outside of (or inside) a sphere or cylinder; `r` from the centre or axis to the point.
  [[nodiscard]] Plane round(const std::array<double, 3>& r, double radius, bool inside,
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
