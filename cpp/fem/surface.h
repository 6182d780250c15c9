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

/// Edge of the facets of a boundary group, for functions of degree 2.
struct SurfaceEdge {
  std::int64_t middle;              ///< global number of the node at its midpoint
  std::array<std::int64_t, 2> ends; ///< global numbers of the nodes at its ends, ascending
  auto operator<=>(const SurfaceEdge&) const = default;
};

/// Lists the edges of all facets of a group, for functions of degree 2; each edge once, the same list on
/// every rank. Collective. Throws UserError naming `key`, as mesh::Mesh::facets does.
[[nodiscard]] std::vector<SurfaceEdge> edges_on(const Space& space, const std::string& group,
                                                const std::string& key);

/// Facets of a boundary group with their nodes; the same on every rank. Nodes have numbers: first vertices,
/// then, for functions of degree 2, midpoints of edges.
struct SurfaceMesh {
  struct Vertex {
    std::array<double, 3> x; ///< coordinates, m
    PetscInt first_dof;      ///< first global dof
  };
  struct Midpoint {
    Vertex node;
    std::array<int, 2> ends; ///< numbers of the vertices at the ends of its edge
  };
  struct Facet {
    std::array<int, 3> vertices;  ///< numbers of its vertices; the last one is −1 in the plane
    std::array<double, 3> normal; ///< unit normal, out of the body
    /// For degree 2 the numbers of the nodes between vertices 0 and 1 and, in space, 1 and 2, and 2 and 0.
    std::array<int, 3> midpoints{-1, -1, -1};
  };
  std::vector<Vertex> vertices;    ///< ordered by their coordinates
  std::vector<Midpoint> midpoints; ///< empty for degree 1
  std::vector<Facet> facets;       ///< ordered by their vertices

  [[nodiscard]] int nodes() const { return static_cast<int>(vertices.size() + midpoints.size()); }
  [[nodiscard]] const Vertex& node(int number) const {
    const auto i = static_cast<std::size_t>(number);
    return i < vertices.size() ? vertices[i] : midpoints[i - vertices.size()].node;
  }
};

/// Collects the facets of a boundary group from all ranks. Facets on the axis of a body of revolution are
/// left out. Collective. Throws UserError naming `key`: as mesh::Mesh::facets does, and if a facet is inside
/// the body.
[[nodiscard]] SurfaceMesh surface_mesh(const Space& space, const std::string& group, const std::string& key);

} // namespace signorini::fem
