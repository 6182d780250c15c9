// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <array>
#include <cstdint>
#include <vector>

namespace signorini::fem {

/// Connected parts of the mesh; two parts have no node in common.
struct ConnectedParts {
  int count = 0;
  std::vector<int> of_node; ///< part number of each owned node, with the same numbering on every rank
  std::vector<int> of_cell; ///< part number of each owned cell
};
/// Finds the connected parts of the mesh. Collective.
ConnectedParts connected_parts(const Space& space);

/// Longest side of the bounding boxes of the connected parts of the mesh, m. Collective.
double longest_side(const Space& space);

} // namespace signorini::fem
