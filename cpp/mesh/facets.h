// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace signorini::mesh {

/// Node numbers of a cell or facet in ascending order, so that equal cells or facets compare equal. Unused
/// entries contain the largest integer, which sorts behind all node numbers.
using SortedNodes = std::array<std::int64_t, 4>;

inline SortedNodes sorted_nodes(std::span<const std::int64_t> nodes) {
  SortedNodes sorted;
  sorted.fill(std::numeric_limits<std::int64_t>::max());
  std::ranges::copy(nodes, sorted.begin());
  std::ranges::sort(sorted);
  return sorted;
}

/// Facet, as a side of one cell.
struct Facet {
  SortedNodes nodes;
  std::int64_t opposite; ///< vertex of the cell that is not on the facet
};

/// Lists the facets of every cell, sorted by their nodes; a facet between two cells occurs twice. `cells`:
/// (cells × (dim + 1)) node numbers.
inline std::vector<Facet> sorted_facets(int dim, std::span<const std::int64_t> cells) {
  const std::size_t corners = static_cast<std::size_t>(dim) + 1;
  std::vector<Facet> facets;
  for (std::size_t c = 0; c < cells.size(); c += corners)
    for (std::size_t opposite = 0; opposite < corners; ++opposite) {
      std::array<std::int64_t, 3> nodes{};
      for (std::size_t i = 0, k = 0; i < corners; ++i)
        if (i != opposite)
          nodes[k++] = cells[c + i];
      facets.push_back({sorted_nodes(std::span(nodes).first(corners - 1)), cells[c + opposite]});
    }
  std::ranges::sort(facets, {}, &Facet::nodes);
  return facets;
}

/// Selects the facets that belong to one cell only, which form the boundary, from the result of
/// sorted_facets().
inline std::vector<Facet> outer_facets(const std::vector<Facet>& sorted) {
  std::vector<Facet> outer;
  for (std::size_t f = 0; f < sorted.size(); ++f)
    if (f + 1 < sorted.size() && sorted[f].nodes == sorted[f + 1].nodes)
      ++f;
    else
      outer.push_back(sorted[f]);
  return outer;
}

} // namespace signorini::mesh
