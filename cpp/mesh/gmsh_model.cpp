// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh_model.h"
#include "base/error.h"
#include "base/text.h"
#include "mesh/element_size.h"
#include "mesh/msh_file.h"
#include "mesh/words.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <fstream>
#include <gmsh.h>
#include <iterator>
#include <limits>
#include <span>
#include <sstream>
#include <string_view>
#include <unordered_map>

namespace signorini::mesh {
namespace {

using Tag = std::size_t;

/// Initialises and finalises gmsh, whose state is process-wide, around the reading of one file.
class Session {
public:
  Session() {
    gmsh::initialize(0, nullptr, false, false);
    gmsh::option::setNumber("General.Terminal", 0);
    gmsh::logger::start();
  }
  ~Session() {
    try {
      gmsh::finalize();
    } catch (...) { // a destructor must not throw
    }
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
};

/// gmsh's first error message, as its exceptions often carry only the last; `fallback` if it logged none.
std::string complaint(const std::string& fallback) {
  std::vector<std::string> log;
  gmsh::logger::get(log);
  for (const std::string& line : log)
    if (line.starts_with("Error: "))
      return line.substr(7);
  return fallback;
}

const char* kind(int dim) {
  constexpr std::array names{"point", "curve", "surface", "volume"};
  return names.at(dim);
}

/// Name of gmsh's for elements of an entity that are no straight simplices; empty if all are.
std::string foreign_elements(int dim, int entity) {
  std::vector<int> types;
  gmsh::model::mesh::getElementTypes(types, dim, entity);
  for (int type : types) {
    std::string name;
    int element_dim = 0, order = 0, nodes = 0, primary = 0;
    std::vector<double> local;
    gmsh::model::mesh::getElementProperties(type, name, element_dim, order, nodes, local, primary);
    if (nodes != dim + 1)
      return name;
  }
  return {};
}

struct PhysicalGroup {
  int dim, tag;
  std::vector<int> entities;
};

/// Node numbers of a cell or facet in ascending order, so that equal ones compare equal; unused entries hold
/// the largest integer.
using Simplex = std::array<std::int64_t, 4>;

Simplex simplex(const std::int64_t* nodes, int count) {
  Simplex sorted;
  sorted.fill(std::numeric_limits<std::int64_t>::max()); // sorts behind all node numbers
  std::copy_n(nodes, count, sorted.begin());
  std::ranges::sort(sorted);
  return sorted;
}

/// A facet of one cell.
struct Facet {
  Simplex nodes;
  std::int64_t opposite; ///< the cell's vertex opposite of it
};

/// Extracts gmsh's current model and validates it. Throws UserError.
class Extraction {
public:
  /// `entities_are_groups`: of elements read with Mesh.SwitchElementTags, whose entities are numbered as
  /// their groups. `names`: of groups, where the file has them.
  Extraction(const scene::Mesh& mesh, bool entities_are_groups, MshFile::GroupNames names)
      : file_(mesh.file.string()), metres_(scene::metres(mesh.unit)),
        entities_are_groups_(entities_are_groups), names_(std::move(names)) {}

  RawMesh run() {
    require_dimension();
    if (entities_are_groups_)
      number_from_one();
    std::vector<std::int64_t> cells = cell_tags();
    number_points(cells);
    raw_.cells = rows_of(cells);
    require_extent();
    keep_single_cells();
    collect_facets();
    collect_groups();
    name_untagged();
    return std::move(raw_);
  }

private:
  [[noreturn]] void fail(const std::string& text) const {
    throw UserError(fmt::format("{}: {}", file_, text));
  }

  void require_dimension() {
    std::vector<int> types;
    for (int dim = 3; dim >= 0 && types.empty(); --dim) {
      gmsh::model::mesh::getElementTypes(types, dim);
      raw_.dim = dim;
    }
    if (types.empty())
      fail(
          "the mesh has no elements (is the file incomplete?), allowed is a mesh of triangles or tetrahedra");
    if (raw_.dim < 2)
      fail(fmt::format(
          "the highest elements of the mesh are those of a {}, allowed is a mesh of triangles or tetrahedra",
          kind(raw_.dim)));
  }

  /// Numbers entities, which are groups, from 1: gmsh takes a negative number, of a group that is passed
  /// through backwards, for all of them.
  void number_from_one() {
    gmsh::vectorpair entities;
    gmsh::model::getEntities(entities);
    int last = 0;
    for (const auto& [dim, entity] : entities)
      last = std::max(last, entity);
    for (const auto& [dim, entity] : entities) {
      const int number = entity < 0 ? ++last : entity;
      if (number != entity)
        gmsh::model::setTag(dim, entity, number);
      if (entity != 0) // of what is in no group
        entities_of_[{dim, std::abs(entity)}].push_back(number);
    }
  }

  /// Node tags of the cells, entity by entity.
  std::vector<std::int64_t> cell_tags() {
    gmsh::vectorpair entities;
    gmsh::model::getEntities(entities, raw_.dim);
    std::vector<std::int64_t> cells;
    for (const auto& [dim, entity] : entities) {
      if (const std::string name = foreign_elements(dim, entity); !name.empty())
        fail(fmt::format("found elements of type \"{}\", not {}; mesh with Mesh.ElementOrder = 1 and without "
                         "Recombine (mesh.degree = 2 gives displacements of degree 2)",
                         name, words(dim).straight_cells));
      const std::vector<std::int64_t> own = entity_tags(dim, entity);
      const auto begin = static_cast<std::int64_t>(cells.size());
      cells.insert(cells.end(), own.begin(), own.end());
      const auto end = static_cast<std::int64_t>(cells.size());
      if (begin < end)
        range_[entity] = {begin / (dim + 1), end / (dim + 1)};
    }
    return cells;
  }

  static std::vector<std::int64_t> entity_tags(int dim, int entity) {
    std::vector<int> types;
    std::vector<std::vector<Tag>> elements, nodes;
    gmsh::model::mesh::getElements(types, elements, nodes, dim, entity);
    std::vector<std::int64_t> tags;
    for (const auto& block : nodes)
      tags.insert(tags.end(), block.begin(), block.end());
    return tags;
  }

  void number_points(const std::vector<std::int64_t>& cells) {
    std::vector<Tag> tags;
    std::vector<double> parametric;
    gmsh::model::mesh::getNodes(tags, drawn_, parametric);
    for (std::size_t i = 0; i < tags.size(); ++i)
      drawn_row_[static_cast<std::int64_t>(tags[i])] = i;
    std::vector<std::int64_t> used = cells;
    std::ranges::sort(used);
    const auto [last, end] = std::ranges::unique(used);
    used.erase(last, end);
    double extent = 0, off_plane = 0;
    for (std::int64_t tag : used) {
      require_node(tag);
      number_[tag] = static_cast<std::int64_t>(raw_.points.size() / 3);
      const std::array<double, 3> x = drawn(tag);
      if (!std::isfinite(x[0]) || !std::isfinite(x[1]) || !std::isfinite(x[2]))
        fail(
            fmt::format("node {} is at ({}, {}, {}), allowed are finite coordinates", tag, x[0], x[1], x[2]));
      raw_.points.insert(raw_.points.end(), x.begin(), x.end());
      extent = std::max({extent, std::abs(x[0]), std::abs(x[1])});
      off_plane = std::max(off_plane, std::abs(x[2]));
    }
    if (raw_.dim == 2 && off_plane > 1e-12 * extent)
      fail(fmt::format(
          "the triangles leave the plane z = 0 by {} m, allowed are triangles in that plane, or tetrahedra",
          off_plane));
  }

  void require_node(std::int64_t tag) const {
    if (!drawn_row_.contains(tag))
      fail(fmt::format("an element refers to node {}, which the file does not have", tag));
  }

  /// Coordinates of a node of the file, m.
  [[nodiscard]] std::array<double, 3> drawn(std::int64_t tag) const {
    const double* x = &drawn_[3 * drawn_row_.at(tag)];
    return {metres_ * x[0], metres_ * x[1], metres_ * x[2]};
  }

  /// Rows of nodes that cells have.
  [[nodiscard]] std::vector<std::int64_t> rows_of(const std::vector<std::int64_t>& tags) const {
    std::vector<std::int64_t> rows;
    rows.reserve(tags.size());
    for (std::int64_t tag : tags)
      rows.push_back(number_.at(tag));
    return rows;
  }

  [[nodiscard]] const double* point(std::int64_t node) const { return &raw_.points[3 * node]; }

  /// A node's coordinates for messages.
  [[nodiscard]] std::string place(std::int64_t node) const { return point_text(point(node), raw_.dim); }

  /// Determinant of the edges from a cell's first corner, and the product of their lengths.
  [[nodiscard]] std::pair<double, double> extent(const std::int64_t* cell) const {
    const int dim = raw_.dim;
    std::array<std::array<double, 3>, 3> e{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    double lengths = 1;
    for (int i = 0; i < dim; ++i) {
      for (int c = 0; c < dim; ++c)
        e[i][c] = point(cell[i + 1])[c] - point(cell[0])[c];
      lengths *= std::hypot(e[i][0], e[i][1], e[i][2]);
    }
    const double determinant = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
                               e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                               e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
    return {determinant, lengths};
  }

  void require_extent() const {
    for (std::size_t c = 0; c < raw_.cells.size(); c += raw_.dim + 1)
      if (const auto [determinant, lengths] = extent(&raw_.cells[c]);
          !(std::abs(determinant) > 1e-14 * lengths))
        fail(fmt::format("the {0} at {1} has no {2}, allowed are {3} that have one", words(raw_.dim).cell,
                         place(raw_.cells[c]), words(raw_.dim).extent, words(raw_.dim).cells));
  }

  /// Keeps the first copy of each cell: MSH 2 has one for each of its groups. A second copy in one group is
  /// an error, and in MSH 4 any.
  void keep_single_cells() {
    const std::size_t corners = raw_.dim + 1, count = raw_.cells.size() / corners;
    std::vector<std::pair<Simplex, std::int64_t>> cells; // with its row
    for (std::size_t row = 0; row < count; ++row)
      cells.emplace_back(simplex(&raw_.cells[row * corners], raw_.dim + 1), row);
    std::ranges::sort(cells);
    std::vector<std::int64_t> first(count); // row of each cell's first copy
    for (std::size_t i = 0; i < count; ++i) {
      const auto& [nodes, row] = cells[i];
      const bool copy = i > 0 && cells[i - 1].first == nodes;
      first[row] = copy ? first[cells[i - 1].second] : row;
      if (copy && (!entities_are_groups_ || entity_of(cells[i - 1].second) == entity_of(row)))
        fail(fmt::format("the {} at {} is in the mesh twice, allowed is once", words(raw_.dim).cell,
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

  /// Of a cell, by its row as read.
  [[nodiscard]] int entity_of(std::int64_t row) const {
    return std::ranges::find_if(range_,
                                [&](const auto& own) { return own.second[0] <= row && row < own.second[1]; })
        ->first;
  }

  /// Collects the cells' facets; each may belong to one cell, or to two that are on either side of it.
  void collect_facets() {
    const int corners = raw_.dim + 1;
    for (std::size_t c = 0; c < raw_.cells.size(); c += corners)
      for (int opposite = 0; opposite < corners; ++opposite) {
        std::array<std::int64_t, 3> nodes{};
        for (int i = 0, k = 0; i < corners; ++i)
          if (i != opposite)
            nodes[k++] = raw_.cells[c + i];
        facets_.push_back({simplex(nodes.data(), raw_.dim), raw_.cells[c + opposite]});
      }
    std::ranges::sort(facets_, {}, &Facet::nodes);
    for (std::size_t f = 0; f + 1 < facets_.size(); ++f) {
      if (facets_[f].nodes != facets_[f + 1].nodes)
        continue;
      if (f + 2 < facets_.size() && facets_[f].nodes == facets_[f + 2].nodes)
        fail(fmt::format("more than two {} share the {} at {}, allowed are one or two", words(raw_.dim).cells,
                         words(raw_.dim).facet, place(facets_[f].nodes[0])));
      if ((side(facets_[f]) > 0) == (side(facets_[f + 1]) > 0))
        fail(
            fmt::format("the two {0} that share the {1} at {2} overlap, allowed are {0} on either side of it",
                        words(raw_.dim).cells, words(raw_.dim).facet, place(facets_[f].nodes[0])));
    }
  }

  /// Its sign tells on which side of the facet the cell lies.
  [[nodiscard]] double side(const Facet& facet) const {
    Simplex cell = facet.nodes;
    cell[raw_.dim] = facet.opposite;
    return extent(cell.data()).first;
  }

  [[nodiscard]] std::vector<PhysicalGroup> physical_groups() const {
    std::vector<PhysicalGroup> groups;
    for (const auto& [group, entities] : entities_of_)
      groups.push_back({group.first, group.second, entities});
    if (entities_are_groups_)
      return groups;
    gmsh::vectorpair found;
    gmsh::model::getPhysicalGroups(found);
    for (const auto& [dim, tag] : found) {
      PhysicalGroup& group = groups.emplace_back();
      group.dim = dim, group.tag = tag;
      gmsh::model::getEntitiesForPhysicalGroup(dim, tag, group.entities);
    }
    return groups;
  }

  /// Of a group, and whether that is its number.
  [[nodiscard]] std::pair<std::string, bool> name_of(int dim, int tag) const {
    std::string name;
    if (const auto found = names_.find({dim, tag}); found != names_.end())
      name = found->second;
    else
      gmsh::model::getPhysicalName(dim, tag, name);
    return name.empty() ? std::pair{std::to_string(tag), true} : std::pair{name, false};
  }

  void collect_groups() {
    std::map<std::pair<int, std::string>, bool> numbers; // whether a name is the number of a group without
    for (const PhysicalGroup& group : physical_groups()) {
      const auto [name, number] = name_of(group.dim, group.tag);
      if (numbers.try_emplace({group.dim, name}, number).first->second != number)
        raw_.unusable[group.dim][name] = "cannot be told from another, which has no name but this number; "
                                         "give that one a name";
      if (group.dim == raw_.dim)
        add_part(name, group);
      else if (group.dim == raw_.dim - 1)
        add_facets(name, group);
      else
        raw_.other_groups[name] = group.dim;
    }
    find_incomplete_groups();
    for (auto& [name, cells] : part_rows_)
      raw_.parts[name] = ranges(cells);
    for (const auto& [name, reason] : raw_.unusable[raw_.dim])
      raw_.parts.erase(name);
    for (const auto& [name, reason] : raw_.unusable[raw_.dim - 1])
      raw_.facets.erase(name);
  }

  /// gmsh leaves entities that a .geo does not draw, or no longer after a boolean operation, out of groups.
  void find_incomplete_groups() {
    std::vector<std::string> log;
    gmsh::logger::get(log);
    constexpr std::string_view skipping = "Skipping unknown ";
    for (const std::string& line : log) {
      const std::size_t at = line.find(skipping);
      if (at == std::string::npos) // curve 9 in physical curve 2
        continue;
      std::istringstream words(line.substr(at + skipping.size()));
      std::string what, in, physical, group;
      int entity = 0, tag = 0;
      words >> what >> entity >> in >> physical >> group >> tag;
      for (int dim = raw_.dim - 1; words && dim <= raw_.dim; ++dim)
        if (group == kind(dim))
          raw_.unusable[dim][name_of(dim, tag).first] = fmt::format(
              "lists {} {}, which is not drawn (any more, after boolean operations); correct the list", what,
              entity);
    }
  }

  void add_part(const std::string& name, const PhysicalGroup& group) {
    std::vector<std::int64_t>& cells = part_rows_[name];
    for (int entity : group.entities)
      if (const auto found = range_.find(entity); found != range_.end())
        cells.insert(cells.end(), &kept_[found->second[0]], &kept_[found->second[1] - 1] + 1);
  }

  /// First rows, and those past the last, of runs of rows, which are sorted.
  static std::vector<std::int64_t> ranges(std::vector<std::int64_t>& rows) {
    std::ranges::sort(rows);
    std::vector<std::int64_t> found;
    for (const std::int64_t row : rows)
      if (!found.empty() && row <= found.back())
        found.back() = row + 1;
      else
        found.insert(found.end(), {row, row + 1});
    return found;
  }

  /// A group whose elements are no facets of cells, such as a floor that is drawn, is unusable, which matters
  /// where the scene names it.
  void add_facets(const std::string& name, const PhysicalGroup& group) {
    const Words& word = words(raw_.dim);
    std::vector<std::int64_t>& facets = raw_.facets[name];
    for (int entity : group.entities) {
      if (const std::string type = foreign_elements(group.dim, entity); !type.empty()) {
        raw_.unusable[group.dim][name] = fmt::format(
            "has elements of type \"{}\", not {}; mesh with Mesh.ElementOrder = 1 and without Recombine",
            type, word.straight_facets);
        return;
      }
      const std::vector<std::int64_t> tags = entity_tags(group.dim, entity);
      std::ranges::for_each(tags, [&](std::int64_t tag) { require_node(tag); });
      for (std::size_t i = 0; i < tags.size(); i += raw_.dim) {
        const std::span own(&tags[i], raw_.dim);
        if (!std::ranges::all_of(own, [&](std::int64_t tag) { return number_.contains(tag); }) ||
            !is_facet(rows_of({own.begin(), own.end()}))) {
          raw_.unusable[group.dim][name] = fmt::format(
              "has the {0} at {1}, which is the {0} of no {2}; name a group of {3} of {4}", word.facet,
              point_text(drawn(own[0]).data(), raw_.dim), word.cell, word.facets, word.cells);
          return;
        }
      }
      const std::vector<std::int64_t> rows = rows_of(tags);
      facets.insert(facets.end(), rows.begin(), rows.end());
    }
    bounded_ |= !facets.empty();
  }

  [[nodiscard]] bool is_facet(const std::vector<std::int64_t>& nodes) const {
    return std::ranges::binary_search(facets_, simplex(nodes.data(), raw_.dim), {}, &Facet::nodes);
  }

  /// Names the body and its boundary where the file does not. Where some cells have a group, all must.
  void name_untagged() {
    const std::size_t count = raw_.cells.size() / (raw_.dim + 1);
    std::vector<bool> grouped(count);
    for (const auto& [name, rows] : part_rows_)
      for (const std::int64_t row : rows)
        grouped[row] = true;
    const auto tagged = static_cast<std::size_t>(std::ranges::count(grouped, true));
    if (0 < tagged && tagged < count)
      fail_ungrouped(grouped);
    const auto taken = [&](const char* name) {
      return raw_.parts.contains(name) || raw_.facets.contains(name);
    };
    if (tagged == 0 && !taken("body")) {
      raw_.parts["body"] = {0, static_cast<std::int64_t>(count)};
      raw_.notes.push_back(fmt::format("no {} of the mesh is in a physical group; all are the group \"body\"",
                                       words(raw_.dim).cell));
    }
    if (!bounded_ && !taken("boundary")) {
      raw_.facets["boundary"] = boundary();
      raw_.notes.push_back(fmt::format(
          "no {} of the body is in a physical group; its whole boundary is the group \"boundary\"",
          words(raw_.dim).facet));
    }
  }

  [[noreturn]] void fail_ungrouped(const std::vector<bool>& grouped) const {
    const Words& word = words(raw_.dim);
    for (const auto& [entity, rows] : range_) {
      const auto bare = std::count_if(&kept_[rows[0]], &kept_[rows[1] - 1] + 1,
                                      [&](std::int64_t row) { return !grouped[row]; });
      if (bare == 0)
        continue;
      std::vector<int> numbers{entity};
      if (entities_are_groups_) // then this is its number, or the first of several entities'
        gmsh::model::getPhysicalGroupsForEntity(raw_.dim, entity, numbers);
      const int number = numbers.empty() ? entity : numbers.front();
      fail(fmt::format("{0} {1} has {2} {3} in no physical group, though others are in one; add it to one, "
                       "such as: Physical {4}(\"body\") = {{{1}}};, or delete it",
                       kind(raw_.dim), number, bare, bare == 1 ? word.cell : word.cells, word.body_kind));
    }
    std::abort(); // some range has that cell
  }

  /// The facets of one cell only.
  [[nodiscard]] std::vector<std::int64_t> boundary() const {
    std::vector<std::int64_t> nodes;
    for (std::size_t f = 0; f < facets_.size(); ++f) {
      if (f + 1 < facets_.size() && facets_[f].nodes == facets_[f + 1].nodes)
        ++f;
      else
        nodes.insert(nodes.end(), facets_[f].nodes.begin(), facets_[f].nodes.begin() + raw_.dim);
    }
    return nodes;
  }

  std::string file_;
  double metres_; ///< length of the file's unit
  bool entities_are_groups_;
  MshFile::GroupNames names_;
  std::map<std::pair<int, int>, std::vector<int>> entities_of_; ///< of groups, if these are entities
  RawMesh raw_;
  std::vector<double> drawn_; ///< coordinates of all nodes of the file, in its unit
  std::unordered_map<std::int64_t, std::size_t> drawn_row_;
  std::unordered_map<std::int64_t, std::int64_t> number_;
  std::map<int, std::array<std::int64_t, 2>> range_; ///< entity → its rows of the cells as read
  std::vector<std::int64_t> kept_;                   ///< row as read → row in raw_.cells
  std::map<std::string, std::vector<std::int64_t>> part_rows_;
  bool bounded_ = false;      ///< whether some group has facets of cells
  std::vector<Facet> facets_; ///< of every cell, sorted; a facet between two cells appears twice
};

/// Sets options by which a .geo asks for other cells than straight simplices to those that give them; a note
/// for each that it had set. Cells are straight in any case, and the degree is the scene's.
std::vector<std::string> ask_for_straight_simplices() {
  std::vector<std::string> notes;
  for (const auto& [option, value] :
       {std::pair{"Mesh.ElementOrder", 1.0}, std::pair{"Mesh.RecombineAll", 0.0},
        std::pair{"Mesh.Recombine3DAll", 0.0}, std::pair{"Mesh.SubdivisionAlgorithm", 0.0}}) {
    double asked = value;
    gmsh::option::getNumber(option, asked);
    if (asked == value)
      continue;
    gmsh::option::setNumber(option, value);
    notes.push_back(fmt::format("{} = {:g} of the .geo has no effect: cells are straight triangles or "
                                "tetrahedra, and mesh.degree = 2 gives displacements of degree 2",
                                option, asked));
  }
  return notes;
}

/// Throws UserError for a .geo whose last line has several statements and no end: gmsh drops all but the
/// first without a word.
void require_last_line(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::string last = text.substr(text.find_last_of('\n') + 1); // npos + 1 is 0
  const std::size_t first = last.find(';');
  const std::size_t next = first == std::string::npos ? first : last.find_first_not_of(" \t\r", first + 1);
  if (next != std::string::npos && last.compare(next, 2, "//") != 0)
    throw UserError(
        fmt::format("{}: its last line has several statements and no end, of which gmsh reads only "
                    "the first; end it with a newline",
                    file));
}

/// Joins what was divided among processes, without ghost cells, which are copies.
void join_partitions() {
  if (gmsh::model::getNumberOfPartitions() > 0)
    gmsh::model::mesh::unpartition();
}

/// Throws UserError if gmsh has dropped elements or nodes, as it does if two have one number.
void require_all(const MshFile& msh, const std::string& file) {
  std::vector<int> types;
  std::vector<std::vector<Tag>> elements, nodes;
  gmsh::model::mesh::getElements(types, elements, nodes);
  std::size_t read = 0;
  for (const auto& block : elements)
    read += block.size();
  if (read < msh.elements())
    throw UserError(
        fmt::format("{}: announces {} elements, of which {} have numbers of their own; number them "
                    "anew, each once",
                    file, msh.elements(), read));
  std::vector<std::string> log;
  gmsh::logger::get(log);
  constexpr std::string_view dropped = "Skipping duplicate node ";
  for (const std::string& line : log)
    if (const std::size_t at = line.find(dropped); at != std::string::npos)
      throw UserError(fmt::format("{}: has node {} twice; number nodes anew, each once", file,
                                  line.substr(at + dropped.size())));
}

/// Takes away what the .geo has meshed itself (Mesh 2; Save …), which gmsh would keep whatever size is asked
/// for; false where there is nothing else, as of a mesh that it merges. Throws UserError where that has a
/// size.
bool is_to_be_meshed(const scene::Mesh& mesh) {
  std::vector<std::size_t> nodes;
  std::vector<double> coordinates, parameters;
  gmsh::model::mesh::getNodes(nodes, coordinates, parameters);
  if (nodes.empty())
    return true;
  gmsh::vectorpair entities;
  gmsh::model::getEntities(entities);
  const bool discrete = std::ranges::any_of(entities, [](const auto& entity) {
    std::string type;
    gmsh::model::getType(entity.first, entity.second, type);
    return type.starts_with("Discrete");
  });
  if (!discrete)
    gmsh::model::mesh::clear();
  else if (mesh.size || mesh.automatic() || mesh.scale != 1)
    throw UserError(fmt::format("mesh.size: has no effect on {}, which merges a mesh and has no geometry; "
                                "allowed without a size, or with a .geo that has one",
                                mesh.file.string()));
  return !discrete;
}

} // namespace

RawMesh read_gmsh_here(const scene::Mesh& mesh, const Meshing& meshing) {
  const std::string file = mesh.file.string();
  if (!std::ifstream(file) || std::filesystem::is_directory(mesh.file))
    throw UserError(
        fmt::format("mesh.file: {} cannot be read, allowed is the path of a .geo or .msh file", file));
  std::optional<MshFile> msh;
  if (mesh.meshed())
    msh.emplace(mesh.file);
  const std::string opened = msh ? msh->path() : file;
  const auto cannot_read = [&](std::string said) {
    if (const std::size_t at = said.find(opened); at != std::string::npos)
      said.replace(at, opened.size(), file);
    return UserError(fmt::format("{}: gmsh cannot read it: {}{}", file, said,
                                 msh ? "; write it anew, with gmsh or as MSH 2.2" : ""));
  };
  const Session session;
  std::vector<std::string> notes;
  try {
    const bool groups_per_cell = msh && msh->version() < 3;
    if (groups_per_cell) // read by its groups: its entities may be anything, such as all of them 1
      gmsh::option::setNumber("Mesh.SwitchElementTags", 1);
    if (!msh)
      require_last_line(file);
    gmsh::open(opened);
    join_partitions();
    if (!mesh.meshed()) {
      const double metres = scene::metres(mesh.unit);
      if (meshing.sizes) {
        set_sizes(*meshing.sizes, metres);
      } else if (mesh.automatic()) {
        set_coarsest_size();
      } else if (mesh.size) {
        require_few_cells(mesh, opened);
        set_size(*mesh.size / metres);
      }
      gmsh::option::setNumber("Mesh.MeshSizeFactor", mesh.scale);
      notes = ask_for_straight_simplices();
      if (is_to_be_meshed(mesh))
        gmsh::model::mesh::generate(gmsh::model::getDimension());
    }
    if (const std::string error = complaint(""); !error.empty())
      throw cannot_read(error);
    if (msh)
      require_all(*msh, file);
    RawMesh raw = Extraction(mesh, groups_per_cell, msh ? msh->group_names() : MshFile::GroupNames()).run();
    raw.notes.insert(raw.notes.end(), notes.begin(), notes.end());
    if (!msh && !meshing.keep.empty()) {
      gmsh::option::setNumber("Mesh.Binary", 1);
      gmsh::option::setNumber("Mesh.SaveAll", 1); // what is in no group too
      gmsh::write(meshing.keep.string());
    }
    return raw;
  } catch (const UserError&) {
    throw;
  } catch (const std::exception& error) {
    throw cannot_read(complaint(error.what()));
  }
}

namespace {

/// The groups of one dimension, for gmsh: elements that are in the same ones make an entity.
void add_entities(int dim, const std::vector<std::int64_t>& elements,
                  const std::vector<std::vector<std::string>>& groups) {
  const auto corners = static_cast<std::size_t>(dim) + 1;
  constexpr std::array types{15, 1, 2, 4}; // of gmsh: points, lines, triangles, tetrahedra
  std::map<std::vector<std::string>, std::vector<Tag>> entities;
  for (std::size_t i = 0; i < groups.size(); ++i)
    for (std::size_t j = 0; j < corners; ++j)
      entities[groups[i]].push_back(static_cast<Tag>(elements[i * corners + j] + 1));
  std::map<std::string, std::vector<int>> of_group;
  for (const auto& [names, nodes] : entities) {
    const int entity = gmsh::model::addDiscreteEntity(dim);
    gmsh::model::mesh::addElementsByType(entity, types.at(static_cast<std::size_t>(dim)), {}, nodes);
    for (const std::string& name : names)
      of_group[name].push_back(entity);
  }
  for (const auto& [name, own] : of_group)
    gmsh::model::addPhysicalGroup(dim, own, -1, name);
}

} // namespace

void write_msh_here(const RawMesh& mesh, const std::filesystem::path& file, scene::LengthUnit unit) {
  const double metres = scene::metres(unit);
  const Session session;
  gmsh::model::add("mesh");
  const auto dim = static_cast<std::size_t>(mesh.dim);
  std::vector<Tag> tags(mesh.points.size() / 3);
  std::vector<double> points = mesh.points;
  for (std::size_t i = 0; i < tags.size(); ++i)
    tags[i] = i + 1;
  for (double& x : points)
    x /= metres;
  // All nodes are one entity's, which has nothing else.
  gmsh::model::mesh::addNodes(mesh.dim, gmsh::model::addDiscreteEntity(mesh.dim), tags, points);
  std::vector<std::vector<std::string>> groups(mesh.cells.size() / (dim + 1));
  for (const auto& [name, ranges] : mesh.parts)
    for (std::size_t r = 0; r < ranges.size(); r += 2)
      for (std::int64_t cell = ranges[r]; cell < ranges[r + 1]; ++cell)
        groups[static_cast<std::size_t>(cell)].push_back(name);
  add_entities(mesh.dim, mesh.cells, groups);
  std::map<Simplex, std::pair<std::vector<std::int64_t>, std::vector<std::string>>> named;
  for (const auto& [name, facets] : mesh.facets)
    for (std::size_t f = 0; f < facets.size(); f += dim) {
      auto& [nodes, names] = named[simplex(&facets[f], mesh.dim)];
      nodes.assign(&facets[f], &facets[f] + dim);
      if (names.empty() || names.back() != name)
        names.push_back(name);
    }
  std::vector<std::int64_t> facets;
  groups.clear();
  for (const auto& [sorted, facet] : named) {
    facets.insert(facets.end(), facet.first.begin(), facet.first.end());
    groups.push_back(facet.second);
  }
  add_entities(mesh.dim - 1, facets, groups);
  gmsh::option::setNumber("Mesh.Binary", 1);
  gmsh::option::setNumber("Mesh.SaveAll", 1); // the nodes' entity is in no group
  gmsh::write(file.string());
}

} // namespace signorini::mesh
