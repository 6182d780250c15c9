#pragma once
#include "fem/space.h"
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace signorini::io {

/// The points of V's owned nodes (× 3), of which those at one place, as on either side of a crack, are moved a little way into
/// the cells that they belong to: that tells them apart on any number of ranks. Collective.
std::vector<double> distinct_points(const fem::Space& space);

/// The same for the vertices (n × dim) of a mesh that a file holds, given with its `cells` ((dim + 1) vertices each), in
/// place. Rank-local. False if a cell has a vertex that is not there.
bool separate(std::vector<double>& points, const std::vector<std::int64_t>& cells, const fem::Space& space);

/// For each of this rank's points `here` (places × 3) the number of the same point among `there` (points ×
/// dim), which may differ in the last digits and in order. Throws UserError, by way of `fail(problem)`, where
/// there is none or two of `there` are the same. Collective.
std::vector<std::size_t> match_points(const fem::Space& space, const std::vector<double>& there,
                                      const std::vector<double>& here,
                                      const std::function<void(const std::string& problem)>& fail);

} // namespace signorini::io
