// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/mesh.h"
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace signorini::mesh {

/// Element sizes wanted for a new mesh, given at the nodes of an old mesh and linear in its cells.
struct SizeField {
  int dim = 2;
  std::vector<double> points{};      ///< (nodes × 3), m
  std::vector<std::int64_t> cells{}; ///< (cells × (dim + 1)), rows into points
  std::vector<double> sizes{};       ///< element size wanted at each node, m
};

/// Area (m²) or volume (m³) of each cell.
std::vector<double> volumes(const SizeField& field);

/// Approximate number of cells that a mesh with the sizes of the field would have, if its cells were regular
/// simplices.
double count_of(const SizeField& field);

/// Reduces the sizes at a curved boundary where necessary: at least `around` elements must fit around a
/// circle with the boundary's curvature. Corners, where the boundary turns by 30 degrees or more, do not
/// count as curved.
void limit_by_curvature(SizeField& field, double around);

/// Reduces sizes where necessary, so that sizes at two points differ by at most a third of their distance.
void limit_growth(SizeField& field);

/// Text of a .geo file that includes the file `body` (geometry and groups) and sets the sizes of the field.
/// `body`: path that is absolute or relative to the new file; `metres`: length of the unit of both files, m.
std::string geo_with_sizes(const SizeField& field, const std::filesystem::path& body, double metres);

/// Computes the sizes that reduce an error to `reduction` times its value with the fewest cells. The error is
/// assumed to fall as the square of the size. `indicators`: contribution to the error of each cell that this
/// rank owns. Sizes are proportional to (indicator/h^(dim + 2))^(−1/(dim + 2)), with h the present size,
/// limited as by limit_growth(); they are at most `reach` times larger or smaller than those of `mesh`.
/// Returns the sizes on rank 0, an empty field on other ranks. Collective.
SizeField sizes_by(const Mesh& mesh, std::span<const double> indicators, double reduction, double reach);

/// Computes sizes like the collective sizes_by(), for cells that are all on this rank. `mesh`: cells without
/// sizes; `error`: contribution of each cell to the error. Not collective.
SizeField sizes_by(SizeField mesh, const std::vector<double>& error, double reduction, double reach);

/// Gathers the cells of all ranks, without sizes, and one number per cell. `numbers`: one number for each
/// cell that this rank owns; `all`: becomes one number for each cell of the result. The result is the same on
/// every rank. Collective.
SizeField gather_cells(const Mesh& mesh, std::span<const double> numbers, std::vector<double>& all);

} // namespace signorini::mesh
