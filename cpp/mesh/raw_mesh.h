// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace signorini::mesh {

/// A mesh of straight simplices as gmsh returns it, not distributed.
struct RawMesh {
  int dim = 0;                     ///< 2 or 3
  std::vector<double> points;      ///< (nodes × 3), m; only nodes that a cell uses
  std::vector<std::int64_t> cells; ///< (cells × (dim + 1)), rows into points
  /// Boundary group → (facets × dim), rows into points.
  std::map<std::string, std::vector<std::int64_t>> facets;
  /// Group of cells → (ranges × 2), ascending: first row into cells and one past the last.
  std::map<std::string, std::vector<std::int64_t>> parts;
  std::map<std::string, int> other_groups; ///< groups of lower dimensions → that dimension
  /// Dimension → group of cells or facets that cannot be used → why, as a predicate with what to do.
  std::map<int, std::map<std::string, std::string>> unusable;
  std::vector<std::string> notes; ///< how ambiguities of the file were resolved, a sentence each
};

/// Serialises a mesh to bytes, for another process on this machine or a digest.
std::string packed(const RawMesh& mesh);

/// Inverse of packed(). Throws std::logic_error if the bytes are too few.
RawMesh unpacked(std::string_view bytes);

} // namespace signorini::mesh
