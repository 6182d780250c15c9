// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace signorini::mesh {

/// Words of messages for the parts of a mesh of a dimension.
struct Words {
  const char *cell, *cells, *facet, *facets;
  const char* extent;                           ///< "area" or "volume", which a degenerate cell lacks
  const char* body_kind;                        ///< of a Physical group in a .geo
  const char *straight_cells, *straight_facets; ///< with gmsh's names
};

inline constexpr Words plane_words{.cell = "triangle",
                                   .cells = "triangles",
                                   .facet = "edge",
                                   .facets = "edges",
                                   .extent = "area",
                                   .body_kind = "Surface",
                                   .straight_cells = "straight triangles (Triangle 3)",
                                   .straight_facets = "straight edges (Line 2)"};
inline constexpr Words space_words{.cell = "tetrahedron",
                                   .cells = "tetrahedra",
                                   .facet = "face",
                                   .facets = "faces",
                                   .extent = "volume",
                                   .body_kind = "Volume",
                                   .straight_cells = "straight tetrahedra (Tetrahedron 4)",
                                   .straight_facets = "straight triangles (Triangle 3)"};

inline const Words& words(int dim) { return dim == 2 ? plane_words : space_words; }

} // namespace signorini::mesh
