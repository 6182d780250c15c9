// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <array>
#include <cstdint>
#include <vector>

namespace signorini::fem {

/// Relative difference up to which values count as equal when the place of the largest is reported. It is far
/// above the rounding on another number of ranks, and below the digits of a message.
inline constexpr double tie = 1e-6;

/// Largest value of a quantity and its place. Of places with equal values it is the one of the least
/// coordinates, x before y before z, so that no partition of the mesh changes it.
struct Largest {
  double value = 0;
  std::array<double, 3> at{}; ///< point of the undeformed body, m: for degree 1 the middle of a cell
};

/// Measures of how much a displacement violates the assumption of small strain.
struct Deformation {
  Largest strain;            ///< modulus of a principal strain
  Largest rotation;          ///< angle of the infinitesimal rotation, ½ |curl y|, rad
  std::int64_t inverted = 0; ///< number of cells with det(I + ∇y) ≤ 0 at a vertex
};

/// Evaluates ∇y at the vertices of all cells, where the strains of degree 1 and 2 are largest. Collective.
Deformation deformation(const Space& space, Vec y);

/// Mean over the body of the cells' longest edges, m. Collective.
double mean_diameter(const Space& space);

/// Largest of all ranks' `of_cells`, values of the cells that each rank owns, in their order; its place is
/// the middle of the cell. Collective.
Largest largest(const Space& space, const std::vector<double>& of_cells);

} // namespace signorini::fem
