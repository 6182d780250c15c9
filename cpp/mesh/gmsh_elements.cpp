// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh_elements.h"
#include <algorithm>
#include <cmath>
#include <gmsh.h>

namespace signorini::mesh {

namespace {

/// Faces of a cell by its number of vertices: pyramid, prism, hexahedron.
const std::vector<std::vector<std::size_t>>& faces_of(std::size_t vertices) {
  static const std::vector<std::vector<std::size_t>> pyramid{
      {0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}},
      prism{{0, 2, 1}, {3, 4, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}},
      hexahedron{{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  return vertices == 5 ? pyramid : vertices == 6 ? prism : hexahedron;
}

/// gmsh's number of the type of straight elements.
int straight_type(int dim, int vertices) {
  constexpr int line = 1, triangle = 2, quadrilateral = 3, tetrahedron = 4, hexahedron = 5, prism = 6,
                pyramid = 7;
  if (dim < 3)
    return dim == 1 ? line : vertices == 3 ? triangle : quadrilateral;
  return vertices == 4 ? tetrahedron : vertices == 5 ? pyramid : vertices == 6 ? prism : hexahedron;
}

/// Calls use(a, b, c) for each triangle of a polygon that is divided by diagonals from its least vertex.
template <class Use>
void divide_polygon(const std::vector<std::int64_t>& polygon, Use&& use) {
  const auto least = static_cast<std::size_t>(std::ranges::min_element(polygon) - polygon.begin());
  const auto at = [&](std::size_t i) { return polygon[(least + i) % polygon.size()]; };
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    use(at(0), at(i), at(i + 1));
}

} // namespace

void divide(int dim, const std::vector<std::int64_t>& vertices, std::vector<std::int64_t>& simplices) {
  if (dim == 2) {
    divide_polygon(vertices, [&](auto a, auto b, auto c) { simplices.insert(simplices.end(), {a, b, c}); });
    return;
  }
  // From the least vertex to the triangles of all faces without it.
  const std::int64_t apex = std::ranges::min(vertices);
  for (const std::vector<std::size_t>& face : faces_of(vertices.size())) {
    std::vector<std::int64_t> polygon;
    for (const std::size_t i : face)
      polygon.push_back(vertices[i]);
    if (std::ranges::find(polygon, apex) == polygon.end())
      divide_polygon(polygon,
                     [&](auto a, auto b, auto c) { simplices.insert(simplices.end(), {apex, a, b, c}); });
  }
}

void GmshElements::measure_bend(int vertices, const std::vector<double>& local, int dim,
                                const std::vector<std::size_t>& nodes, std::size_t each) {
  // Weights of the vertices at the other nodes of a straight element.
  std::vector<double> places, weights;
  for (std::size_t i = static_cast<std::size_t>(vertices); i < each; ++i)
    for (int c = 0; c < 3; ++c)
      places.push_back(c < dim ? local[i * static_cast<std::size_t>(dim) + static_cast<std::size_t>(c)] : 0);
  int components = 0, orientations = 0;
  gmsh::model::mesh::getBasisFunctions(straight_type(dim, vertices), places, "Lagrange", components, weights,
                                       orientations);
  const auto corners = static_cast<std::size_t>(vertices);
  for (std::size_t first = 0; first < nodes.size(); first += each) {
    std::vector<std::array<double, 3>> at;
    double diameter = 0;
    for (std::size_t i = 0; i < corners; ++i) {
      at.push_back(coordinates_(static_cast<std::int64_t>(nodes[first + i])));
      for (const auto& other : at)
        diameter = std::max(
            diameter, std::hypot(at.back()[0] - other[0], at.back()[1] - other[1], at.back()[2] - other[2]));
    }
    for (std::size_t i = corners; i < each; ++i) {
      const auto tag = static_cast<std::int64_t>(nodes[first + i]);
      std::array<double, 3> away = coordinates_(tag);
      for (std::size_t v = 0; v < corners; ++v)
        for (std::size_t c = 0; c < 3; ++c)
          away[c] -= weights[(i - corners) * corners + v] * at[v][c];
      if (const double bend = std::hypot(away[0], away[1], away[2]) / diameter; bend > bend_)
        bend_ = bend, bent_node_ = tag;
    }
  }
}

GmshElements::Found GmshElements::read(int dim, int entity) {
  std::vector<int> types;
  std::vector<std::vector<std::size_t>> elements, nodes;
  gmsh::model::mesh::getElements(types, elements, nodes, dim, entity);
  Found found;
  for (std::size_t block = 0; block < types.size(); ++block) {
    std::string name;
    int element_dim = 0, order = 0, each = 0, vertices = 0;
    std::vector<double> local;
    gmsh::model::mesh::getElementProperties(types[block], name, element_dim, order, each, local, vertices);
    const bool simplex = vertices == dim + 1;
    const bool known = simplex || (dim == 2 && vertices == 4) || (dim == 3 && 5 <= vertices && vertices <= 8);
    if (!known || (!simplex && !split_))
      return {.tags = {}, .refused = name};
    const auto width = static_cast<std::size_t>(each);
    if (order > 1)
      measure_bend(vertices, local, dim, nodes[block], width);
    for (std::size_t first = 0; first < nodes[block].size(); first += width) {
      const auto begin = nodes[block].begin() + static_cast<std::ptrdiff_t>(first);
      const std::vector<std::int64_t> corners(begin, begin + vertices);
      if (order > 1 || !simplex) {
        std::vector<std::int64_t> sorted = corners;
        std::ranges::sort(sorted);
        if (order > 1)
          of_higher_order_.insert(sorted);
        if (!simplex)
          divided_.insert(std::move(sorted));
      }
      if (simplex)
        found.tags.insert(found.tags.end(), corners.begin(), corners.end());
      else
        divide(dim, corners, found.tags);
    }
  }
  return found;
}

} // namespace signorini::mesh
