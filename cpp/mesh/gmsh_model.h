#pragma once
#include "scene/scene.h"
#include <array>
#include <cstdint>
#include <map>
#include <string>
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

/// Reads a .msh, or meshes a .geo at its size. Not collective: call it on one rank.
/// A .geo is meshed up to the dimension of its highest entities: triangles in the plane z = 0, or tetrahedra.
/// Throws UserError for a file that cannot be read, a wrong dimension or element type, cells that are flat,
/// overlap their neighbours or are in no physical group, and boundary groups of other facets than the cells'.
/// gmsh, which may crash on a damaged file, works in a process of its own: then it throws UserError too.
RawMesh read_gmsh(const scene::Mesh& mesh);

/// The same in this process.
RawMesh read_gmsh_here(const scene::Mesh& mesh);

} // namespace signorini::mesh
