// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <array>
#include <cstdint>
#include <vector>

namespace signorini::fem {

/// Relative difference up to which two values count as equal when the location of the largest value is
/// reported. It is far above the rounding differences between numbers of ranks, and below the digits of a
/// message.
inline constexpr double tie = 1e-6;

/// Largest value of a quantity, and where it occurs. Among points with equal values (see `tie`) the one with
/// the least coordinates is taken, x before y before z, so that the partition of the mesh does not matter.
struct Largest {
  double value = 0;
  std::array<double, 3> at{}; ///< undeformed point, m: the cell's midpoint for cellwise values, else a vertex
};

/// Measures of how far a displacement is from the assumption of small strain.
struct Deformation {
  Largest strain;            ///< largest modulus of the principal strains
  Largest rotation;          ///< angle of the infinitesimal rotation, ½ |curl y|, rad
  std::int64_t inverted = 0; ///< number of cells with det(I + ∇y) ≤ 0 at a vertex
};

/// Evaluates the deformation by ∇y at the vertices of all cells, where displacements of degree 1 and 2 have
/// their largest strains. In a body of revolution y_r/r, the strain around the axis, counts; it is taken at
/// the middle of cells of degree 1. Collective.
Deformation deformation(const Space& space, Vec y);

/// Modulus of the largest principal strain of the mean of ∇y, weighted by size, over the cells whose midpoint
/// is within a cell diameter of `at`, the place of Deformation::strain for the same y. It is much smaller
/// than that strain where single cells have it: at facets of a coarse mesh, corners and point loads.
/// Collective.
double strain_around(const Space& space, Vec y, const std::array<double, 3>& at);

/// Mean of the cells' longest edges, weighted by volume, m. Collective.
double mean_diameter(const Space& space);

/// Finds the largest of one value per cell on all ranks. `of_cells`: values of the cells that this rank owns,
/// in the order of the cells. The location returned is the midpoint of the cell. Collective.
Largest largest(const Space& space, const std::vector<double>& of_cells);

} // namespace signorini::fem
