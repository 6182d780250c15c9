#pragma once
#include "fem/space.h"

namespace signorini::fem {

/// Functions of V, of degree 1, as functions of degree 2 on the same mesh: one component stored for all
/// (MAIJ). The rows of vertices have one entry, those of the middles of edges two. Collective.
petsc::Matrix embedding(const Space& linear, const Space& quadratic);

} // namespace signorini::fem
