#pragma once
#include "fem/space.h"
#include <array>
#include <cstdint>

namespace signorini::fem {

/// The largest value of a quantity over the cells' vertices, and where it is attained.
struct Largest {
  double value = 0;
  std::array<double, 3> at{}; ///< point of the undeformed body, m
};

/// How much a displacement violates the assumption of small strain.
struct Deformation {
  Largest strain;            ///< modulus of a principal strain
  Largest rotation;          ///< angle of the infinitesimal rotation, ½ |curl y|, rad
  std::int64_t inverted = 0; ///< number of cells with det(I + ∇y) ≤ 0 at a vertex
};

/// Evaluates ∇y at the vertices of all cells, where the strains of degree 1 and 2 are largest. Costs as much
/// as one or two matrix-vector products. Collective.
Deformation deformation(const Space& space, Vec y);

} // namespace signorini::fem
