// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/facets.h"
#include "mesh/msh_file.h"
#include "mesh/raw_mesh.h"
#include "mesh/simplex.h"
#include "scene/scene.h"
#include <array>
#include <map>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

/// The cells of gmsh's current model, and its groups.
namespace signorini::mesh {

/// Words for the entities of a mesh of some dimension, for messages.
struct Words {
  const char *cell, *cells, *facet, *facets;
  const char* extent;                           ///< "area" or "volume", zero for a degenerate cell
  const char* body_kind;                        ///< kind of a Physical group of cells in a .geo
  const char *straight_cells, *straight_facets; ///< with their names in gmsh
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

/// Name of a dimension's entities in a .geo.
const char* entity_kind(int dim);

/// gmsh's name of elements of an entity that are no straight simplices; empty if all are.
std::string foreign_elements(int dim, int entity);

/// Tags of the nodes of an entity's elements.
std::vector<std::int64_t> node_tags(int dim, int entity);

/// Points and cells of gmsh's current model, validated: triangles in the plane z = 0, or tetrahedra.
class GmshCells {
public:
  /// Reads the model. `entities_are_groups`: for elements read with Mesh.SwitchElementTags, whose entities
  /// are numbered as their groups. Throws UserError.
  GmshCells(const scene::Mesh& mesh, bool entities_are_groups);

  /// Dimension, points and cells; without groups.
  [[nodiscard]] const RawMesh& raw() const { return raw_; }
  /// Facets of every cell, from sorted_facets().
  [[nodiscard]] const std::vector<Facet>& facets() const { return facets_; }
  /// Rows of an entity's cells; empty for one without cells.
  [[nodiscard]] std::span<const std::int64_t> rows_of_entity(int entity) const;
  /// Entities with cells, ascending.
  [[nodiscard]] std::vector<int> entities() const;
  [[nodiscard]] bool entities_are_groups() const { return entities_are_groups_; }
  /// Map from a group's dimension and number to its entities; see entities_are_groups().
  [[nodiscard]] const std::map<std::pair<int, int>, std::vector<int>>& entities_of() const {
    return entities_of_;
  }

  /// Whether a cell has the node of this tag.
  [[nodiscard]] bool has(std::int64_t tag) const { return number_.contains(tag); }
  /// Rows of nodes, by their tags, that cells have.
  [[nodiscard]] std::vector<std::int64_t> rows_of(const std::vector<std::int64_t>& tags) const;
  /// Coordinates of a node of the file, m.
  [[nodiscard]] std::array<double, 3> drawn(std::int64_t tag) const;
  /// Throws UserError unless the file has the node.
  void require_node(std::int64_t tag) const;
  /// Throws UserError with the file's name.
  [[noreturn]] void fail(const std::string& text) const;

private:
  void require_dimension();
  /// Numbers entities, which are groups, from 1: for gmsh a negative number, that of a group passed through
  /// backwards, means all of them.
  void number_from_one();
  /// Tags of the nodes of all cells, entity by entity; sets the rows of each.
  std::vector<std::int64_t> cell_tags();
  void number_points(const std::vector<std::int64_t>& cells);
  void require_extent() const;
  /// Keeps the first copy of each cell: MSH 2 has one for each of its groups. Throws UserError for a second
  /// copy in one group, and in MSH 4 for any.
  void keep_single_cells();
  /// Entity of a cell, by its row as read.
  [[nodiscard]] int entity_of(std::int64_t row) const;
  /// Throws UserError unless each facet belongs to one cell, or to two that are on either side of it.
  void require_facets_apart() const;
  [[nodiscard]] Simplex simplex(const std::int64_t* nodes) const;
  [[nodiscard]] const double* point(std::int64_t node) const { return &raw_.points[3 * node]; }
  /// A node's coordinates for messages.
  [[nodiscard]] std::string place(std::int64_t node) const;

  std::string file_;
  double metres_; ///< length of the file's unit
  bool entities_are_groups_;
  std::map<std::pair<int, int>, std::vector<int>> entities_of_;
  RawMesh raw_;
  std::vector<double> drawn_; ///< coordinates of all nodes of the file, in its unit
  std::unordered_map<std::int64_t, std::size_t> drawn_row_;
  std::unordered_map<std::int64_t, std::int64_t> number_;
  std::map<int, std::array<std::int64_t, 2>> range_; ///< entity → its rows of the cells as read
  std::vector<std::int64_t> kept_;                   ///< row as read → row in raw().cells
  std::vector<Facet> facets_;
};

/// Cells of gmsh's current model with its groups. `names`: names of groups, where the file has them. Throws
/// UserError where some cells are in no group.
RawMesh with_groups(const GmshCells& cells, const MshFile::GroupNames& names);

} // namespace signorini::mesh
