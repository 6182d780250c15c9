// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/facets.h"
#include "mesh/gmsh_elements.h"
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

/// Cells and groups of gmsh's current model.
namespace signorini::mesh {

/// Words for the cells and facets of a mesh of dimension 2 or 3, for messages.
struct Words {
  const char *cell, *cells, *facet, *facets;
  const char* extent;                           ///< measure of a cell: "area" or "volume"
  const char* body_kind;                        ///< kind of a Physical group of cells in a .geo file
  const char *straight_cells, *straight_facets; ///< element types that can be used, with gmsh's names
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

/// Name of an entity of dimension `dim` in a .geo file: point, curve, surface or volume.
const char* entity_kind(int dim);

/// Validated points and cells of gmsh's current model: triangles in the plane z = 0, or tetrahedra.
class GmshCells {
public:
  /// Reads the current model. `entities_are_groups`: whether the elements were read with
  /// Mesh.SwitchElementTags, which makes one entity of each group, with the group's number. Throws UserError
  /// if the cells are invalid.
  GmshCells(const scene::Mesh& mesh, bool entities_are_groups);

  /// Dimension, points (m) and cells of the mesh, without its groups.
  [[nodiscard]] const RawMesh& raw() const { return raw_; }
  /// Facets of every cell, as sorted_facets() lists them.
  [[nodiscard]] const std::vector<Facet>& facets() const { return facets_; }
  /// Rows in raw().cells of the cells of an entity; empty if the entity has no cells.
  [[nodiscard]] std::span<const std::int64_t> rows_of_entity(int entity) const;
  /// Numbers of the entities that have cells, ascending.
  [[nodiscard]] std::vector<int> entities() const;
  [[nodiscard]] bool entities_are_groups() const { return entities_are_groups_; }
  /// Map from a group's dimension and number to the numbers of its entities. Empty unless
  /// entities_are_groups() is true.
  [[nodiscard]] const std::map<std::pair<int, int>, std::vector<int>>& entities_of() const {
    return entities_of_;
  }

  /// Reads the facets of an entity of the lower dimension as GmshElements does.
  [[nodiscard]] GmshElements::Found read_facets(int entity) const;

  /// Whether some cell has the node with this tag.
  [[nodiscard]] bool has(std::int64_t tag) const { return number_.contains(tag); }
  /// Rows in raw().points of nodes, by their tags; each node must belong to a cell.
  [[nodiscard]] std::vector<std::int64_t> rows_of(const std::vector<std::int64_t>& tags) const;
  /// Coordinates of a node of the file, by its tag, m.
  [[nodiscard]] std::array<double, 3> coordinates(std::int64_t tag) const;
  /// Throws UserError unless the file has a node with this tag.
  void require_node(std::int64_t tag) const;
  /// Throws UserError with `text` after the file's name.
  [[noreturn]] void fail(const std::string& text) const;

private:
  void require_dimension();
  /// Renumbers entities, which are groups here, so that all numbers are positive. gmsh assigns a negative
  /// number to a group that is traversed backwards, and takes a negative number in a call to mean all
  /// entities.
  void number_from_one();
  /// Reads the coordinates of all nodes of the file.
  void read_nodes();
  /// Returns the tags of the nodes of all cells, entity by entity, and sets the range of rows of each entity.
  std::vector<std::int64_t> cell_tags();
  void number_points(const std::vector<std::int64_t>& cells);
  void require_extent() const;
  /// Removes repeated cells: MSH 2 lists a cell once for each of its groups. Throws UserError if a cell
  /// occurs twice in one group or, if entities_are_groups() is false, twice in the mesh.
  void keep_single_cells();
  /// Number of the entity that contains a cell. `row`: row of the cell as read, repeated cells included.
  [[nodiscard]] int entity_of(std::int64_t row) const;
  /// Throws UserError unless each facet belongs to one cell, or to two cells on opposite sides of it.
  void require_facets_apart() const;
  [[nodiscard]] Simplex simplex(const std::int64_t* nodes) const;
  [[nodiscard]] const double* point(std::int64_t node) const { return &raw_.points[3 * node]; }
  /// Coordinates of a node as text for messages, m.
  [[nodiscard]] std::string place(std::int64_t node) const;

  /// Throws UserError if the cells are curved and displacements have degree 2, or if none of them is divided
  /// though the scene asks for it; adds notes on elements that are not taken as they are.
  void judge(const GmshElements& elements);

  std::string file_;
  bool split_;    ///< mesh.split
  int degree_;    ///< mesh.degree
  double metres_; ///< length of the file's unit, m
  bool entities_are_groups_;
  std::map<std::pair<int, int>, std::vector<int>> entities_of_;
  RawMesh raw_;
  std::vector<double> drawn_; ///< coordinates of all nodes of the file, in the file's unit
  std::unordered_map<std::int64_t, std::size_t> drawn_row_;
  std::unordered_map<std::int64_t, std::int64_t> number_;
  std::map<int, std::array<std::int64_t, 2>> range_; ///< entity → its rows of the cells as read
  std::vector<std::int64_t> kept_;                   ///< row of a cell as read → row in raw().cells
  std::vector<Facet> facets_;
};

/// Returns the cells of gmsh's current model together with its groups. `names`: names of groups as read from
/// the file, which replace gmsh's. Throws UserError if some cells, but not all, are in no group.
RawMesh with_groups(const GmshCells& cells, const MshFile::GroupNames& names);

} // namespace signorini::mesh
