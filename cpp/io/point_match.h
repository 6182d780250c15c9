// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace signorini::io {

/// Points of V's owned nodes (nodes × 3), m. Coincident ones, such as those on either side of a crack, are
/// moved slightly into the cells that they belong to: they become distinct, alike on any number of ranks.
/// Collective.
std::vector<double> distinct_points(const fem::Space& space);

/// Makes the vertices (n × dim) of a mesh from a file distinct, like distinct_points(), in place; `cells`:
/// its cells (dim + 1 vertices each). Rank-local. Returns false if a cell has a vertex that does not exist.
bool separate(std::vector<double>& points, const std::vector<std::int64_t>& cells, const fem::Space& space);

/// Finds for each of this rank's points `here` (places × 3) the number of the same point among `there`
/// (points × dim), whose order and last digits may differ. Throws UserError, by `fail(problem)`, where there
/// is none or two of `there` are the same. Collective.
std::vector<std::size_t> match_points(const fem::Space& space, const std::vector<double>& there,
                                      const std::vector<double>& here,
                                      const std::function<void(const std::string& problem)>& fail);

} // namespace signorini::io
