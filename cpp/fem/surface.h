// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace signorini::fem {

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

/// Facets of a boundary group with their vertices; the same on every rank.
struct SurfaceMesh {
  struct Vertex {
    std::array<double, 3> x; ///< coordinates, m
    PetscInt first_dof;      ///< first global dof
  };
  struct Facet {
    std::array<int, 3> vertices;  ///< numbers of its vertices; the last one is −1 in the plane
    std::array<double, 3> normal; ///< unit normal, out of the body
  };
  std::vector<Vertex> vertices; ///< ordered by their coordinates
  std::vector<Facet> facets;    ///< ordered by their vertices
};

/// Collects the facets of a boundary group from all ranks. Facets on the axis of a body of revolution are
/// left out. Collective. Throws UserError naming `key`: as mesh::Mesh::facets does, and if a facet is inside
/// the body.
[[nodiscard]] SurfaceMesh surface_mesh(const Space& space, const std::string& group, const std::string& key);

} // namespace signorini::fem
