// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <vector>

namespace signorini::mesh {

/// Reads the elements of gmsh's current model as straight simplices. Elements of higher order are taken at
/// their vertices. Quadrilaterals, hexahedra, prisms and pyramids are divided on request, without new nodes:
/// each face by the diagonal from its vertex with the least tag, so that neighbours divide it alike.
class GmshElements {
public:
  /// Coordinates of a node by its tag, in any unit. May throw for an unknown tag.
  using Coordinates = std::function<std::array<double, 3>(std::int64_t tag)>;

  /// `split`: whether elements other than simplices are divided.
  GmshElements(bool split, Coordinates coordinates) : split_(split), coordinates_(std::move(coordinates)) {}

  /// What reading the elements of an entity found.
  struct Found {
    std::vector<std::int64_t> tags; ///< nodes of the simplices, (n × (dim + 1))
    std::string refused{};          ///< gmsh's name of a type of elements that cannot be read; then no tags
  };
  [[nodiscard]] Found read(int dim, int entity);

  /// Number of elements that have been divided. An element in several groups counts once.
  [[nodiscard]] std::size_t divided() const { return divided_.size(); }
  /// Number of elements of higher order that have been taken at their vertices.
  [[nodiscard]] std::size_t of_higher_order() const { return of_higher_order_.size(); }
  /// Largest distance of a node between the vertices from where it would be in a straight element, relative
  /// to the diameter of the element; and the tag of that node.
  [[nodiscard]] double bend() const { return bend_; }
  [[nodiscard]] std::int64_t bent_node() const { return bent_node_; }

private:
  void measure_bend(int vertices, const std::vector<double>& local, int dim,
                    const std::vector<std::size_t>& nodes, std::size_t each);
  bool split_;
  Coordinates coordinates_;
  std::set<std::vector<std::int64_t>> divided_, of_higher_order_; ///< elements, by their sorted vertices
  double bend_ = 0;
  std::int64_t bent_node_ = 0;
};

/// Divides a convex cell with these vertices, in gmsh's order, into simplices of dimension `dim`: appends
/// their vertices to `simplices`. Source: J. Dompierre et al., How to subdivide pyramids, prisms, and
/// hexahedra into tetrahedra, 8th International Meshing Roundtable (1999).
void divide(int dim, const std::vector<std::int64_t>& vertices, std::vector<std::int64_t>& simplices);

} // namespace signorini::mesh
