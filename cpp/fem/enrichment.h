#pragma once
#include "fem/space.h"

namespace signorini::fem {

/// From V, of degree 1, to the space of degree 2 on the same mesh, which holds what V lacks of smooth functions. Matrices
/// from one to the other, one component stored for all (MAIJ).
struct Enrichment {
  petsc::Matrix embed; ///< y as a function of degree 2
  /// What the function of degree 2 recovered from y has beyond y: zero at the vertices, and in the middle of each edge
  /// (∇y_a − ∇y_b)·(x_b − x_a)/8 with the gradients at its ends averaged over the cells there, by volume (Zienkiewicz
  /// and Zhu 1987): right for functions of degree 2 on regular meshes, a first-order guess at boundaries.
  petsc::Matrix surplus;
};

/// Collective.
Enrichment enrich(const Space& linear, const Space& quadratic);

} // namespace signorini::fem
