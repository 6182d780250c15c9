// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <cstdint>
#include <vector>

namespace signorini::fem {

/// The connected parts of the mesh, which share no node.
struct ConnectedParts {
  int count = 0;
  std::vector<int> of_node; ///< the number of its part, of each owned node, the same on every rank
};
/// Collective.
ConnectedParts connected_parts(const Space& space);

/// Number of facets of a group, on all ranks, with a cell on either side. Collective. Throws UserError naming
/// `key`, as mesh::Mesh::facets does.
std::int64_t inner_facets(const mesh::Mesh& mesh, const std::string& group, const std::string& key);

/// Number of facets of a group, on all ranks, all of whose nodes are in `first_dofs`: the first global dofs
/// of nodes, ascending, of all ranks. Collective. Throws UserError naming `key`, as mesh::Mesh::facets does.
std::int64_t facets_among(const Space& space, const std::string& group, const std::string& key,
                          const std::vector<PetscInt>& first_dofs);

} // namespace signorini::fem
