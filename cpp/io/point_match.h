// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace signorini::io {

/// Points of the nodes of V that this rank owns (nodes × 3), m. Coincident nodes, as on the two sides of a
/// crack, are moved slightly into their cells, so that all points are distinct. The result does not depend on
/// the number of ranks. Collective.
std::vector<double> distinct_points(const fem::Space& space);

/// Moves coincident points among `points` (n × dim), the vertices of a mesh read from a file, slightly into
/// their cells, as distinct_points() does for nodes. `cells`: the cells of that mesh, dim + 1 vertices each.
/// Returns false if points coincide but `cells` is invalid. Not collective.
bool separate(std::vector<double>& points, const std::vector<std::int64_t>& cells, const fem::Space& space);

/// Finds for each point in `here` (places × 3, on this rank) the number of the same point in `there` (points
/// × dim, the same on all ranks). Order and last digits of the coordinates may differ. Calls `fail(problem)`,
/// which must throw UserError, if a point is missing in `there` or two points of `there` coincide.
/// Collective.
std::vector<std::size_t> match_points(const fem::Space& space, const std::vector<double>& there,
                                      const std::vector<double>& here,
                                      const std::function<void(const std::string& problem)>& fail);

} // namespace signorini::io
