// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/point.h"
#include "mesh/raw_mesh.h"
#include <cstddef>
#include <string>
#include <vector>

namespace signorini::mesh {

/// Sizes and qualities of a mesh.
struct Statistics {
  /// Group of cells, or of facets of the boundary or between cells.
  struct Group {
    std::string name;
    std::size_t elements;
    double measure;         ///< volume, area or length, m^dim
    Point centre;           ///< m
    std::size_t inside = 0; ///< number of facets between two cells
  };
  Point low{}, high{};                   ///< corners of the box around the mesh, m
  std::size_t connected = 0;             ///< number of connected parts
  double shortest = 0, longest = 0;      ///< edges, m
  double least_quality = 1, quality = 0; ///< least and mean ratio of radii: of the inscribed circle or sphere
                                         ///< to the circumscribed one, times dim; 1 for regular simplices
  std::size_t poor = 0;                  ///< number of cells with a ratio below poor_quality
  std::vector<Group> cells, facets;

  static constexpr double poor_quality = 0.1;
};

/// Computes the statistics of a mesh that has a cell.
Statistics statistics(const RawMesh& mesh);

} // namespace signorini::mesh
