// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace signorini::mesh {

/// Undistributed mesh of straight simplices, as gmsh provides it.
struct RawMesh {
  int dim = 0;                     ///< 2 or 3
  std::vector<double> points;      ///< (nodes × 3), m; only nodes that belong to a cell
  std::vector<std::int64_t> cells; ///< (cells × (dim + 1)), rows of `points`
  /// Name of a boundary group → its facets (facets × dim), rows of `points`.
  std::map<std::string, std::vector<std::int64_t>> facets;
  /// Name of a group of cells → ranges of rows of `cells` (ranges × 2), ascending. A range is stored as its
  /// first row and its last row + 1.
  std::map<std::string, std::vector<std::int64_t>> parts;
  std::map<std::string, int> other_groups; ///< names of groups of lower dimensions → dimension
  /// Dimension → name of an unusable group of cells or facets → reason and remedy, as the predicate of a
  /// sentence.
  std::map<int, std::map<std::string, std::string>> unusable;
  std::vector<std::string> notes; ///< how ambiguities of the file were resolved, one sentence each
};

/// Serialises a mesh to bytes, as input for another process on this machine or for a digest.
std::string packed(const RawMesh& mesh);

/// Decodes a mesh from the result of packed(). Throws std::logic_error if bytes are missing.
RawMesh unpacked(std::string_view bytes);

} // namespace signorini::mesh
