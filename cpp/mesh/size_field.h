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
  std::vector<double> sizes{};       ///< of each node, m
};

/// Area or volume of each cell, m² or m³.
std::vector<double> volumes(const SizeField& field);

/// Cells that a mesh of these sizes has, about: those of regular simplices.
double count_of(const SizeField& field);

/// Makes sizes at a boundary that bends smaller, if need be, so that at least `around` elements would go once
/// around a circle of its curvature; corners, where it turns by 30 degrees and more, do not bend.
void limit_by_curvature(SizeField& field, double around);

/// Makes sizes smaller, if need be, so that they grow by no more than a third of the distance.
void limit_growth(SizeField& field);

/// A .geo with the body and the groups of another, `body`, whose path is absolute or relative to the new
/// file, and the sizes of the field. `metres`: length of the files' unit.
std::string geo_with_sizes(const SizeField& field, const std::filesystem::path& body, double metres);

/// Sizes with which an error that falls as the square of the size, of which each cell owned has its part in
/// `indicators`, falls to the part `reduction` of what it is, by the fewest cells: sizes are then as
/// (indicator per volume and size²)^(−1/(dim + 2)). They grow by no more than a third of the distance, and no
/// element becomes more than `reach` times as small or large. The result is on rank 0, empty elsewhere.
/// Collective.
SizeField sizes_by(const Mesh& mesh, std::span<const double> indicators, double reduction, double reach);

/// The same of a mesh and the part of the error that each of its cells has. Not collective.
SizeField sizes_by(SizeField mesh, const std::vector<double>& error, double reduction, double reach);

/// The mesh without sizes and, in `all`, the numbers of its cells, of which each rank gives those that it
/// owns; on every rank. Collective.
SizeField gathered(const Mesh& mesh, std::span<const double> numbers, std::vector<double>& all);

} // namespace signorini::mesh
