// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/forms.h"
#include "mesh/size_field.h"

namespace signorini::fem {

/// Where a computed stress is off, by the one that is recovered from it (Zienkiewicz, Zhu 1987): of each cell
/// the energy ½ ∫ (σ* − σ) : (ε* − ε), σ* and ε* being linear with the means, by volume, of the cells of one
/// material at a node. Of displacements of degree 1.
class StressRecovery {
public:
  /// For the body's parts. Collective.
  StressRecovery(const Space& space, const std::vector<Part>& parts);

  /// Adds `weight` times the energies of a displacement (m). Collective.
  void add(Vec y, double weight);

  /// The sums, J (in the plane J/m) times the weights' unit, of all cells of mesh(), on every rank.
  [[nodiscard]] const std::vector<double>& sums() const { return sums_; }
  /// All cells, those of the ranks one after the other, without sizes; on every rank.
  [[nodiscard]] const mesh::SizeField& mesh() const { return cells_; }

private:
  /// The tensors of a field, 3 × 3 for each cell of mesh(), on every rank. Collective.
  std::vector<double> tensors(CellField field);

  const Space& space_;
  CellFields fields_;
  petsc::Vector rest_;
  mesh::SizeField cells_;
  std::vector<std::size_t> rows_; ///< of each corner of each cell, in means at the nodes of one material
  std::vector<double> volumes_, sums_;
};

} // namespace signorini::fem
