// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <array>
#include <cstdint>
#include <vector>

namespace signorini::fem {

/// The connected parts of the mesh, which share no node.
struct ConnectedParts {
  int count = 0;
  std::vector<int> of_node; ///< part number of each owned node, numbered alike on every rank
};
/// Finds the connected parts of the mesh. Collective.
ConnectedParts connected_parts(const Space& space);

/// Number of facets of a group, on all ranks, with a cell on either side. Collective. Throws UserError naming
/// `key`, as mesh::Mesh::facets does.
std::int64_t inner_facets(const mesh::Mesh& mesh, const std::string& group, const std::string& key);

/// Number of facets of a group, on all ranks, whose nodes are all in `first_dofs`: the first global dofs of
/// nodes, ascending, of all ranks. Collective. Throws UserError naming `key`, as mesh::Mesh::facets does.
std::int64_t facets_among(const Space& space, const std::string& group, const std::string& key,
                          const std::vector<PetscInt>& first_dofs);

/// A node of the boundary and the normal of a facet there.
struct OutwardNormal {
  PetscInt first_dof;      ///< first global dof of the node
  std::array<double, 3> n; ///< unit vector out of the body
};

/// Outward normals: one for each facet of the boundary that this rank owns and each of its nodes. Collective.
std::vector<OutwardNormal> outward_normals(const Space& space);

} // namespace signorini::fem
