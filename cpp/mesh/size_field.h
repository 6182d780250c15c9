// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/mesh.h"
#include <span>
#include <vector>

namespace signorini::mesh {

/// Sizes that the elements of a new mesh are to have, given at the corners of the cells of an old one and
/// linear between.
struct SizeField {
  int dim = 2;
  std::vector<double> points;      ///< (nodes × 3), m
  std::vector<std::int64_t> cells; ///< (cells × (dim + 1)), rows into points
  std::vector<double> sizes;       ///< of each node, m
};

/// Sizes with which an error that falls as the square of the size, of which each cell owned has its part in
/// `indicators`, falls to the part `reduction` of what it is, by the fewest cells: sizes are then as
/// (indicator per volume and size²)^(−1/(dim + 2)). They grow by no more than a third of the distance, and no
/// element becomes more than `reach` times as small or large. The result is on rank 0, empty elsewhere.
/// Collective.
SizeField sizes_by(const Mesh& mesh, std::span<const double> indicators, double reduction, double reach);

/// The mesh on rank 0, without sizes, and there in `all` the numbers of its cells, of which each rank gives
/// those that it owns. Collective.
SizeField gathered(const Mesh& mesh, std::span<const double> numbers, std::vector<double>& all);

} // namespace signorini::mesh
