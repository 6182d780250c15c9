// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/mesh.h"
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace signorini::mesh {

/// Sizes that the elements of a new mesh are to have, given at the corners of the cells of an old one and
/// linear between.
struct SizeField {
  int dim = 2;
  std::vector<double> points{};      ///< (nodes × 3), m
  std::vector<std::int64_t> cells{}; ///< (cells × (dim + 1)), rows into points
  std::vector<double> sizes{};       ///< size at each node, m
};

/// Area or volume of each cell, m² or m³.
std::vector<double> volumes(const SizeField& field);

/// Approximate number of cells of a mesh with these sizes, for regular simplices.
double count_of(const SizeField& field);

/// Reduces sizes at a curved boundary where necessary, so that at least `around` elements would fit around a
/// circle of its curvature. Corners, where it turns by 30 degrees and more, do not count as curved.
void limit_by_curvature(SizeField& field, double around);

/// Reduces sizes where necessary, so that they grow by no more than a third of the distance.
void limit_growth(SizeField& field);

/// Text of a .geo with the sizes of the field, and the body and groups of another .geo, `body`, whose path is
/// absolute or relative to the new file. `metres`: length of the files' unit.
std::string geo_with_sizes(const SizeField& field, const std::filesystem::path& body, double metres);

/// Chooses sizes that reduce an error to the part `reduction` of its value by the fewest cells. The error
/// falls as the square of the size; `indicators` are the parts of the owned cells in it. Sizes are then as
/// (indicator per volume and size²)^(−1/(dim + 2)). They grow by no more than a third of the distance, and no
/// element becomes more than `reach` times as small or large. The result is on rank 0, empty elsewhere.
/// Collective.
SizeField sizes_by(const Mesh& mesh, std::span<const double> indicators, double reduction, double reach);

/// Chooses sizes like the collective sizes_by(), for a mesh and the part of the error in each of its cells.
/// Not collective.
SizeField sizes_by(SizeField mesh, const std::vector<double>& error, double reduction, double reach);

/// Gathers the mesh without sizes and, in `all`, the numbers of its cells on every rank; `numbers`: those of
/// the cells that this rank owns. Collective.
SizeField gathered(const Mesh& mesh, std::span<const double> numbers, std::vector<double>& all);

} // namespace signorini::mesh
