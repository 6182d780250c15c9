// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/forms.h"
#include "mesh/size_field.h"

namespace signorini::fem {

/// Error estimate of a computed stress by the one recovered from it (Zienkiewicz, Zhu 1987): in each cell the
/// energy ½ ∫ (σ* − σ) : (ε* − ε). At a node the linear σ* and ε* are the means, by volume, over the cells of
/// one material. For displacements of degree 1.
class StressRecovery {
public:
  /// Sets the estimate up for the body's parts. Collective.
  StressRecovery(const Space& space, const std::vector<Part>& parts);

  /// Adds `weight` times the energies of a displacement (m) to the sums. Collective.
  void add(Vec y, double weight);

  /// Weighted sums of the energies of all cells of mesh(), J (in the plane J/m) times the weights' unit, on
  /// every rank.
  [[nodiscard]] const std::vector<double>& sums() const { return sums_; }
  /// Mesh of all cells, rank after rank, without sizes; on every rank.
  [[nodiscard]] const mesh::SizeField& mesh() const { return cells_; }

private:
  /// Tensors of a field, 3 × 3 for each cell of mesh(), on every rank. Collective.
  std::vector<double> tensors(CellField field);

  const Space& space_;
  CellFields fields_;
  petsc::Vector rest_;
  mesh::SizeField cells_;
  std::vector<std::size_t> rows_; ///< row of each corner of each cell in the means at nodes
  std::vector<double> volumes_, sums_;
};

/// Largest von Mises stress of the cells, and its recovery from the cells around.
struct StressPeak {
  Largest largest;      ///< Pa, at the middle of the cell
  double recovered = 0; ///< Pa, at the same point, by the linear stress whose value at a node is the
                        ///< mean, by volume, over the cells of one material
  /// Node of the cell on the boundary, m. If the boundary has a corner there that points into the body, it is
  /// the node with the largest angle, else the one with the largest stress around it.
  std::optional<std::array<double, 3>> corner{};
  double angle = 0; ///< angle of the body around `corner`, as a part of the full one; ½ if smooth
};

/// Part of the full angle around a node of the boundary above which the boundary has a corner that points
/// into the body, by 30 degrees or more.
constexpr double reentrant = 0.5 + 1.0 / 12;

/// Finds the largest stress of the motion last set in `fields`, which are those of the body's `parts`.
/// Collective.
StressPeak stress_peak(const Space& space, const std::vector<Part>& parts, CellFields& fields);

} // namespace signorini::fem
