// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/obstacle.h"
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace signorini::contact {

/// A box along the axes, by two corners, m. In the plane the third components are zero.
struct Box {
  std::array<double, 3> low{}, high{};

  /// An empty box, for include() to extend.
  [[nodiscard]] static Box empty(int dim);
  [[nodiscard]] double longest_side() const;
  /// Extends the box to include a point, or `other`.
  void include(const std::array<double, 3>& x) { // called for every node at every stored time
    for (std::size_t c = 0; c < 3; ++c) {
      low[c] = std::min(low[c], x[c]);
      high[c] = std::max(high[c], x[c]);
    }
  }
  void include(const Box& other) {
    include(other.low);
    include(other.high);
  }
};

/// A part of an obstacle's surface: line segments in the plane, with the obstacle to their right; triangles
/// in space, counterclockwise as seen from outside of the obstacle.
struct ObstacleSurface {
  std::vector<double> points;       ///< (n × dim), m
  std::vector<std::int64_t> facets; ///< (facets × dim), numbers of points
  bool whole = false;               ///< whether no part of the surface was left out
};

/// The surface at `place` within a box. A ball or cylinder that is not much larger than the box is taken
/// whole, a cylinder up to the ends of the box. Curved surfaces are resolved by `cells` along the longest
/// side.
ObstacleSurface surface_within(const Obstacle& obstacle, const Obstacle::Place& place, int dim,
                               const Box& box, int cells);

} // namespace signorini::contact
