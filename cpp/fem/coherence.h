// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <array>
#include <cstdint>
#include <vector>

namespace signorini::fem {

/// Connected parts of the mesh; two parts have no node in common.
struct ConnectedParts {
  int count = 0;
  std::vector<int> of_node; ///< part number of each owned node, with the same numbering on every rank
};
/// Finds the connected parts of the mesh. Collective.
ConnectedParts connected_parts(const Space& space);

/// Counts, on all ranks, the facets of a group that are inside the body, with a cell on each side.
/// Collective. Throws UserError naming `key`, as mesh::Mesh::facets does.
std::int64_t inner_facets(const mesh::Mesh& mesh, const std::string& group, const std::string& key);

/// Counts, on all ranks, the facets of a group whose nodes all belong to a given set. `first_dofs`: first
/// global dof of each node of the set, ascending, including nodes that other ranks own. Collective. Throws
/// UserError naming `key`, as mesh::Mesh::facets does.
std::int64_t facets_among(const Space& space, const std::string& group, const std::string& key,
                          const std::vector<PetscInt>& first_dofs);

/// Node of the boundary, with the normal of one facet of the boundary at this node.
struct OutwardNormal {
  PetscInt first_dof;      ///< first global dof of the node
  std::array<double, 3> n; ///< unit normal of the facet, out of the body
};

/// Lists the outward normals at the nodes of the boundary: one entry for each facet of the boundary that this
/// rank owns and each node of the facet. Collective.
std::vector<OutwardNormal> outward_normals(const Space& space);

} // namespace signorini::fem
