// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/cell_fields.h"
#include "mesh/size_field.h"

namespace signorini::fem {

/// Error estimate for a computed stress σ by recovery (Zienkiewicz, Zhu 1987): the energy ½ ∫ (σ* − σ) : (ε*
/// − ε) in each cell. The recovered fields σ* and ε* are linear; their values at a node are the means,
/// weighted by volume, over the cells of one material at that node. Valid for displacements of degree 1. The
/// stress is the elastic one; that of branches (Relaxation) is left out.
class StressRecovery {
public:
  /// Sets up the estimate for the parts of the body. Collective.
  StressRecovery(const Space& space, const std::vector<Part>& parts);

  /// Computes the error energy of each cell for a displacement y (m) and adds `weight` times this energy to
  /// sums(). Collective.
  void add(Vec y, double weight);

  /// Weighted sums of the error energies, one for each cell of mesh(), in J (in plane strain and plane stress
  /// J/m) times the unit of the weights; the same on every rank.
  [[nodiscard]] const std::vector<double>& sums() const { return sums_; }
  /// Cells of all ranks, rank after rank, without sizes; the same on every rank.
  [[nodiscard]] const mesh::SizeField& mesh() const { return cells_; }

private:
  /// Tensors of a field, 3 × 3 for each cell of mesh(), the same on every rank. Collective.
  std::vector<double> tensors(CellField field);

  const Space& space_;
  CellFields fields_;
  petsc::Vector rest_;
  mesh::SizeField cells_;
  std::vector<std::size_t> rows_; ///< for each corner of each cell: row in the nodal means
  std::vector<double> volumes_;   ///< areas of the section in axial symmetry
  std::vector<double> depths_;    ///< for each cell, ratio of its volume in the body to volumes_
  std::vector<double> sums_;
};

/// Largest von Mises stress of all cells, and the recovered stress at the same point.
struct StressPeak {
  Largest largest;      ///< largest von Mises stress, Pa, at the midpoint of its cell
  double recovered = 0; ///< Pa, at the same point, from the recovered linear stress: at each node the mean
                        ///< over the cells of one material, weighted by volume
  /// Position of a boundary node of the cell of `largest`, m; absent if this cell has no boundary node. Among
  /// several nodes, it is the reentrant corner with the largest angle or, if none is a reentrant corner, the
  /// node with the largest mean von Mises stress of the cells around it.
  std::optional<std::array<double, 3>> corner{};
  double angle = 0; ///< angle of the body around `corner`, as a fraction of the full angle; about ½ if smooth
};

/// Fraction of the full angle around a boundary node above which the node counts as a reentrant corner: half
/// of the full angle plus 30 degrees.
constexpr double reentrant = 0.5 + 1.0 / 12;

/// Finds the largest von Mises stress for the state last set in `fields`, which must have been set up for the
/// same `parts`. Collective.
StressPeak stress_peak(const Space& space, const std::vector<Part>& parts, CellFields& fields);

} // namespace signorini::fem
