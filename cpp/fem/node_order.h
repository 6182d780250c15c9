// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cstdint>
#include <dolfinx/graph/AdjacencyList.h>
#include <vector>

namespace signorini::fem {

/// Numbers the nodes of an undirected graph, whose links are listed at both ends, by a breadth-first search
/// of each connected component (Cuthill and McKee 1969): neighbours have close numbers, so that a product
/// with a matrix of this graph reads its vector from the cache. Each search begins at a node that is nearly
/// as far from another one as any (George and Liu 1979). Returns the new number of each node.
std::vector<int> breadth_first_order(const dolfinx::graph::AdjacencyList<std::int32_t>& links);

} // namespace signorini::fem
