#pragma once
#include "fem/space.h"
#include <array>
#include <cstdint>

namespace signorini::fem {

/// The largest value of something over the cells' vertices, and where.
struct Largest {
  double value = 0;
  std::array<double, 3> at{}; ///< in the undeformed body, m
};

/// How far a motion is from being a small one.
struct Deformation {
  Largest strain;            ///< modulus of a principal strain
  Largest rotation;          ///< angle by which a place turns, rad
  std::int64_t inverted = 0; ///< cells that det(I + ∇y) ≤ 0 turns inside out at a vertex
};

/// Of y by its gradient at the vertices of all cells, where strains of degree 1 and 2 are largest. As costly as a
/// product with a matrix or two. Collective.
Deformation deformation(const Space& space, Vec y);

} // namespace signorini::fem
