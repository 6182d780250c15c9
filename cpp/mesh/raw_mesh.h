#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace signorini::mesh {

/// A mesh of straight simplices as gmsh has it: plain numbers, no distribution.
struct RawMesh {
  int dim = 0;
  std::vector<double> points;      ///< (nodes × 3), m; only nodes that a cell uses
  std::vector<std::int64_t> cells; ///< (cells × (dim + 1)), rows into points
  std::map<std::string, std::vector<std::int64_t>>
      facets; ///< boundary group → (facets × dim), rows into points
  /// Group of cells → (ranges × 2): first row in cells and the one behind the last.
  std::map<std::string, std::vector<std::int64_t>> parts;
  std::map<std::string, int> other_groups; ///< groups of lower dimensions → that dimension
};

/// A mesh as bytes, on its way from one process to another.
std::string packed(const RawMesh& mesh);

/// The same mesh again. Throws std::logic_error if the bytes are too few.
RawMesh unpacked(std::string_view bytes);

} // namespace signorini::mesh
