// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <array>
#include <cstdint>
#include <vector>

namespace signorini::fem {

/// Relative difference up to which values are equal where the place of the largest is told: far more than
/// other sums and solves on another number of ranks make of it, and less than the digits of a message.
inline constexpr double tie = 1e-6;

/// The largest value of a quantity, and where it is attained: of places with equal values that of the least
/// coordinates, x before y before z, so that no partition of the mesh changes it.
struct Largest {
  double value = 0;
  std::array<double, 3> at{}; ///< point of the undeformed body, m: for degree 1 the middle of a cell
};

/// How much a displacement violates the assumption of small strain.
struct Deformation {
  Largest strain;            ///< modulus of a principal strain
  Largest rotation;          ///< angle of the infinitesimal rotation, ½ |curl y|, rad
  std::int64_t inverted = 0; ///< number of cells with det(I + ∇y) ≤ 0 at a vertex
};

/// Evaluates ∇y at the vertices of all cells, where the strains of degree 1 and 2 are largest. Collective.
Deformation deformation(const Space& space, Vec y);

/// Mean over the body of the cells' longest edges, m. Collective.
double mean_diameter(const Space& space);

/// The largest of values of the cells that this rank owns, in their order, at the middle of the cell.
/// Collective.
Largest largest(const Space& space, const std::vector<double>& of_cells);

} // namespace signorini::fem
