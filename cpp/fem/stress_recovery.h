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

/// The largest von Mises stress of the cells, and how far the cells around make out the same.
struct StressPeak {
  Largest largest;      ///< Pa, at the middle of the cell
  double recovered = 0; ///< Pa, there, of the stress that is linear with the means, by volume, of the cells
                        ///< of one material at a node
  /// A node of the cell on the boundary, m: that with the largest angle if the boundary has a corner there
  /// that points into the body, else that with the largest stress around it.
  std::optional<std::array<double, 3>> corner{};
  double angle = 0; ///< of the body around it, as a part of the full one: ½ where the boundary is smooth
};

/// Part of the full angle around a node of the boundary: beyond it the boundary has a corner that points
/// into the body, by 30 degrees or more.
constexpr double reentrant = 0.5 + 1.0 / 12;

/// Of the last motion set in `fields`, which are those of the body's `parts`. Collective.
StressPeak stress_peak(const Space& space, const std::vector<Part>& parts, CellFields& fields);

} // namespace signorini::fem
