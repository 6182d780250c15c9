#pragma once
#include "fem/space.h"
#include <cstdint>

namespace signorini::fem {

/// Number of parts of the mesh that share no node with each other. Collective.
int connected_parts(const Space& space);

/// Facets of a group, on all ranks, that have a cell on either side. Collective. Throws UserError naming `key`.
std::int64_t inner_facets(const mesh::Mesh& mesh, const std::string& group, const std::string& key);

/// Facets of a group, on all ranks, of which all nodes are in a list of first dofs, ascending. Collective. Throws
/// UserError naming `key`.
std::int64_t facets_among(const Space& space, const std::string& group, const std::string& key,
                          const std::vector<PetscInt>& first_dofs);

} // namespace signorini::fem
