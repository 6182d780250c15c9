// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh_cells.h"
#include "base/error.h"
#include "base/text.h"
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <gmsh.h>

namespace signorini::mesh {

const char* entity_kind(int dim) {
  constexpr std::array names{"point", "curve", "surface", "volume"};
  return names.at(dim);
}

GmshCells::GmshCells(const scene::Mesh& mesh, bool entities_are_groups)
    : file_(mesh.file.string()), split_(mesh.split), degree_(mesh.degree), metres_(mesh.metres()),
      entities_are_groups_(entities_are_groups) {
  require_dimension();
  if (entities_are_groups_)
    number_from_one();
  read_nodes();
  const std::vector<std::int64_t> cells = cell_tags();
  number_points(cells);
  raw_.cells = rows_of(cells);
  require_extent();
  keep_single_cells();
  facets_ = sorted_facets(raw_.dim, raw_.cells);
  require_facets_apart();
}

void GmshCells::fail(const std::string& text) const { throw UserError(fmt::format("{}: {}", file_, text)); }

void GmshCells::require_dimension() {
  std::vector<int> types;
  for (int dim = 3; dim >= 0 && types.empty(); --dim) {
    gmsh::model::mesh::getElementTypes(types, dim);
    raw_.dim = dim;
  }
  if (types.empty())
    fail("the mesh has no elements (is the file incomplete?); use a mesh of triangles or tetrahedra");
  if (raw_.dim < 2)
    fail(fmt::format(
        "the elements of highest dimension are those of a {}; use a mesh of triangles or tetrahedra",
        entity_kind(raw_.dim)));
}

void GmshCells::number_from_one() {
  gmsh::vectorpair entities;
  gmsh::model::getEntities(entities);
  int last = 0;
  for (const auto& [dim, entity] : entities)
    last = std::max(last, entity);
  for (const auto& [dim, entity] : entities) {
    const int number = entity < 0 ? ++last : entity;
    if (number != entity)
      gmsh::model::setTag(dim, entity, number);
    if (entity != 0) // 0: elements in no group
      entities_of_[{dim, std::abs(entity)}].push_back(number);
  }
}

std::vector<std::int64_t> GmshCells::cell_tags() {
  gmsh::vectorpair entities;
  gmsh::model::getEntities(entities, raw_.dim);
  std::vector<std::int64_t> cells;
  GmshElements elements(split_, [this](std::int64_t tag) { return coordinates(tag); });
  for (const auto& [dim, entity] : entities) {
    const auto [own, refused] = elements.read(dim, entity);
    if (!refused.empty())
      fail(fmt::format("found elements of type \"{}\", not {}; set mesh.split = true, which divides them",
                       refused, words(dim).straight_cells));
    const auto begin = static_cast<std::int64_t>(cells.size());
    cells.insert(cells.end(), own.begin(), own.end());
    const auto end = static_cast<std::int64_t>(cells.size());
    if (begin < end)
      range_[entity] = {begin / (dim + 1), end / (dim + 1)};
  }
  judge(elements);
  return cells;
}

void GmshCells::judge(const GmshElements& elements) {
  constexpr double straight = 1e-3; // less than what the coordinates of short formats are rounded by
  const Words& word = words(raw_.dim);
  if (elements.bend() > straight && degree_ > 1)
    fail(fmt::format("has curved elements: the node at {} is {:.2g} of its element's diameter away from "
                     "where it is in a straight one. mesh.degree = 2 needs straight {}; set mesh.degree = 1, "
                     "which takes the vertices, or mesh with straight elements",
                     point_text(coordinates(elements.bent_node()).data(), raw_.dim), elements.bend(),
                     word.cells));
  if (elements.of_higher_order() > 0)
    raw_.notes.push_back(
        fmt::format("{} elements of higher order are taken at their vertices{}", elements.of_higher_order(),
                    elements.bend() > straight
                        ? fmt::format("; some are curved, by up to {:.2g} of their diameter", elements.bend())
                        : ""));
  if (elements.divided() > 0)
    raw_.notes.push_back(fmt::format("{} elements are divided into {}", elements.divided(), word.cells));
  else if (split_)
    fail(fmt::format("mesh.split has no effect: the file has {} only; remove it", word.cells));
}

GmshElements::Found GmshCells::read_facets(int entity) const {
  return GmshElements(split_, [this](std::int64_t tag) { return coordinates(tag); })
      .read(raw_.dim - 1, entity);
}

void GmshCells::read_nodes() {
  std::vector<std::size_t> tags;
  std::vector<double> parametric;
  gmsh::model::mesh::getNodes(tags, drawn_, parametric);
  for (std::size_t i = 0; i < tags.size(); ++i)
    drawn_row_[static_cast<std::int64_t>(tags[i])] = i;
}

void GmshCells::number_points(const std::vector<std::int64_t>& cells) {
  std::vector<std::int64_t> used = cells;
  std::ranges::sort(used);
  const auto [last, end] = std::ranges::unique(used);
  used.erase(last, end);
  double extent = 0, off_plane = 0;
  for (std::int64_t tag : used) {
    require_node(tag);
    number_[tag] = static_cast<std::int64_t>(raw_.points.size() / 3);
    const std::array<double, 3> x = coordinates(tag);
    if (!std::isfinite(x[0]) || !std::isfinite(x[1]) || !std::isfinite(x[2]))
      fail(fmt::format("node {} is at ({}, {}, {}); expected finite coordinates", tag, x[0], x[1], x[2]));
    raw_.points.insert(raw_.points.end(), x.begin(), x.end());
    extent = std::max({extent, std::abs(x[0]), std::abs(x[1])});
    off_plane = std::max(off_plane, std::abs(x[2]));
  }
  if (raw_.dim == 2 && off_plane > 1e-12 * extent)
    fail(
        fmt::format("the triangles leave the plane z = 0 by {} m; use triangles in that plane, or tetrahedra",
                    off_plane));
}

void GmshCells::require_node(std::int64_t tag) const {
  if (!drawn_row_.contains(tag))
    fail(fmt::format("an element refers to node {}, which the file does not have", tag));
}

std::array<double, 3> GmshCells::coordinates(std::int64_t tag) const {
  require_node(tag);
  const double* x = &drawn_[3 * drawn_row_.at(tag)];
  return {metres_ * x[0], metres_ * x[1], metres_ * x[2]};
}

std::vector<std::int64_t> GmshCells::rows_of(const std::vector<std::int64_t>& tags) const {
  std::vector<std::int64_t> rows;
  rows.reserve(tags.size());
  for (std::int64_t tag : tags)
    rows.push_back(number_.at(tag));
  return rows;
}

std::string GmshCells::place(std::int64_t node) const { return point_text(point(node), raw_.dim); }

Simplex GmshCells::simplex(const std::int64_t* nodes) const {
  return {raw_.dim, [&](int i) { return point(nodes[i]); }};
}

void GmshCells::require_extent() const {
  for (std::size_t c = 0; c < raw_.cells.size(); c += raw_.dim + 1)
    if (const Simplex cell = simplex(&raw_.cells[c]); !(cell.abs_determinant() > 1e-14 * cell.edge_product()))
      fail(fmt::format("the {0} at {1} has zero {2}; use {3} that are not degenerate", words(raw_.dim).cell,
                       place(raw_.cells[c]), words(raw_.dim).extent, words(raw_.dim).cells));
}

void GmshCells::keep_single_cells() {
  const std::size_t corners = raw_.dim + 1, count = raw_.cells.size() / corners;
  std::vector<std::pair<SortedNodes, std::int64_t>> cells; // nodes and row
  for (std::size_t row = 0; row < count; ++row)
    cells.emplace_back(sorted_nodes(std::span(raw_.cells).subspan(row * corners, corners)), row);
  std::ranges::sort(cells);
  std::vector<std::int64_t> first(count); // row of each cell's first copy
  for (std::size_t i = 0; i < count; ++i) {
    const auto& [nodes, row] = cells[i];
    const bool copy = i > 0 && cells[i - 1].first == nodes;
    first[row] = copy ? first[cells[i - 1].second] : row;
    if (copy && (!entities_are_groups_ || entity_of(cells[i - 1].second) == entity_of(row)))
      fail(fmt::format("the {} at {} is in the mesh twice; remove one", words(raw_.dim).cell,
                       place(nodes[0])));
  }
  std::vector<std::int64_t> single;
  kept_.resize(count);
  for (std::size_t row = 0; row < count; ++row) {
    if (first[row] == static_cast<std::int64_t>(row)) {
      kept_[row] = static_cast<std::int64_t>(single.size() / corners);
      const auto cell = raw_.cells.begin() + static_cast<std::ptrdiff_t>(row * corners);
      single.insert(single.end(), cell, cell + static_cast<std::ptrdiff_t>(corners));
    } else {
      kept_[row] = kept_[first[row]];
    }
  }
  raw_.cells = std::move(single);
}

int GmshCells::entity_of(std::int64_t row) const {
  return std::ranges::find_if(range_,
                              [&](const auto& own) { return own.second[0] <= row && row < own.second[1]; })
      ->first;
}

std::vector<int> GmshCells::entities() const {
  std::vector<int> found;
  for (const auto& [entity, rows] : range_)
    found.push_back(entity);
  return found;
}

std::span<const std::int64_t> GmshCells::rows_of_entity(int entity) const {
  const auto found = range_.find(entity);
  if (found == range_.end())
    return {};
  const auto [begin, end] = found->second;
  return std::span(kept_).subspan(begin, end - begin);
}

void GmshCells::require_facets_apart() const {
  const auto side = [&](const Facet& facet) { // its sign is the side of the facet on which the cell lies
    SortedNodes cell = facet.nodes;
    cell[raw_.dim] = facet.opposite;
    return simplex(cell.data()).determinant();
  };
  for (std::size_t f = 0; f + 1 < facets_.size(); ++f) {
    if (facets_[f].nodes != facets_[f + 1].nodes)
      continue;
    if (f + 2 < facets_.size() && facets_[f].nodes == facets_[f + 2].nodes)
      fail(fmt::format("more than two {} share the {} at {}; at most two may", words(raw_.dim).cells,
                       words(raw_.dim).facet, place(facets_[f].nodes[0])));
    if ((side(facets_[f]) > 0) == (side(facets_[f + 1]) > 0))
      fail(fmt::format("the two {0} that share the {1} at {2} overlap; they must lie on either side of it",
                       words(raw_.dim).cells, words(raw_.dim).facet, place(facets_[f].nodes[0])));
  }
}

} // namespace signorini::mesh
