// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"

namespace signorini::fem {

/// Matrix of the embedding of functions of degree 1 (columns) into those of degree 2 (rows) on the same mesh:
/// 1 at vertices, ½ from both ends at midpoints of edges; one component is stored for all (MAIJ). Collective.
petsc::Matrix embedding(const Space& linear, const Space& quadratic);

} // namespace signorini::fem
