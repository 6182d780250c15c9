// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/obstacle_surface.h"
#include "contact/pairs.h"
#include <cstdint>
#include <span>
#include <vector>

namespace signorini::io {

/// Places of an obstacle with mass at several times; empty for an obstacle without.
using Places = std::vector<contact::RigidMotion::Place>;

/// Motion of an obstacle's surface: points of the surface at t = 0, and their displacements.
struct SurfaceMotion {
  contact::ObstacleSurface surface; ///< one surface; if the shape changes, the surfaces of all times
  std::vector<double> displacement; ///< (times × n × dim); if the shape changes, (n × dim); m; empty at rest
  /// First point and first facet of each time, with the end; empty unless the shape changes.
  std::vector<std::int64_t> first_point, first_facet;

  /// Whether the surface has other facets at each time.
  [[nodiscard]] bool renewed() const { return !first_point.empty(); }
  /// Whether the surface is elsewhere at each time.
  [[nodiscard]] bool moves() const { return !displacement.empty(); }
};

/// Computes the motion of the part of the i-th obstacle's surface that is within the box `shown` (m), at
/// `times` (s). `places`: of an obstacle with mass at these times.
SurfaceMotion surface_motion(const contact::ContactPairs& pairs, int i, const contact::Box& shown,
                             std::span<const double> times, const Places& places);

} // namespace signorini::io
