// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/box.h"
#include "contact/obstacle.h"
#include <cstdint>
#include <vector>

namespace signorini::contact {

/// Part of an obstacle's surface. In the plane it consists of line segments with the obstacle on their right,
/// in space of triangles that are counterclockwise as seen from outside of the obstacle.
struct ObstacleSurface {
  std::vector<double> points;       ///< (n × dim), m
  std::vector<std::int64_t> facets; ///< (facets × dim), rows of `points`
  bool whole = false;               ///< whether this is the whole surface of the obstacle
};

/// Computes the part of the obstacle's surface at `place` that is within a box. A ball or cylinder that is
/// not much larger than the box is returned whole (a cylinder up to the ends of the box). `cells`: number of
/// grid cells along the longest side of the box in which a curved surface is sampled.
ObstacleSurface surface_within(const Obstacle& obstacle, const Obstacle::Place& place, int dim,
                               const Box& box, int cells);

} // namespace signorini::contact
