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
#include <fmt/format.h>
#include <fstream>
#include <gmsh.h>
#include <limits>
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

std::string group_name(int dim, int tag) {
  std::string name;
  gmsh::model::getPhysicalName(dim, tag, name);
  return name.empty() ? std::to_string(tag) : name;
}

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
  explicit Extraction(const scene::Mesh& mesh)
      : file_(mesh.file.string()), metres_(scene::metres(mesh.unit)) {}

  RawMesh run() {
    require_dimension();
    std::vector<std::int64_t> cells = cell_tags();
    number_points(cells);
    raw_.cells = renumber(cells);
    require_extent();
    require_single_cells();
    collect_facets();
    groups();
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
    require_straight(raw_.dim, words(raw_.dim).straight_cells);
    require_straight(raw_.dim - 1, words(raw_.dim).straight_facets);
  }

  void require_straight(int dim, const char* allowed) const {
    std::vector<int> types;
    gmsh::model::mesh::getElementTypes(types, dim);
    for (int type : types) {
      std::string name;
      int element_dim = 0, order = 0, nodes = 0, primary = 0;
      std::vector<double> local;
      gmsh::model::mesh::getElementProperties(type, name, element_dim, order, nodes, local, primary);
      if (nodes != dim + 1)
        fail(fmt::format("found elements of type \"{}\", allowed are {}", name, allowed));
    }
  }

  /// Node tags of the cells; every entity that has cells must be in a physical group.
  std::vector<std::int64_t> cell_tags() {
    gmsh::vectorpair entities;
    gmsh::model::getEntities(entities, raw_.dim);
    std::vector<std::int64_t> cells;
    for (const auto& [dim, entity] : entities) {
      const std::vector<std::int64_t> own = entity_tags(dim, entity);
      if (own.empty())
        continue;
      std::vector<int> groups;
      gmsh::model::getPhysicalGroupsForEntity(dim, entity, groups);
      if (groups.empty())
        fail(
            fmt::format("{} {} has {} elements and is in no physical group, allowed are {}s in a group, such "
                        "as: Physical {}(\"body\") = {{{}}};",
                        kind(dim), entity, own.size() / (dim + 1), kind(dim), words(dim).body_kind, entity));
      const auto begin = static_cast<std::int64_t>(cells.size());
      cells.insert(cells.end(), own.begin(), own.end());
      const auto end = static_cast<std::int64_t>(cells.size());
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
    std::vector<double> points, parametric;
    gmsh::model::mesh::getNodes(tags, points, parametric);
    std::unordered_map<Tag, std::size_t> row;
    for (std::size_t i = 0; i < tags.size(); ++i)
      row[tags[i]] = i;
    std::vector<std::int64_t> used = cells;
    std::ranges::sort(used);
    const auto [last, end] = std::ranges::unique(used);
    used.erase(last, end);
    double extent = 0, off_plane = 0;
    for (std::int64_t tag : used) {
      const auto found = row.find(static_cast<Tag>(tag));
      if (found == row.end())
        fail(fmt::format("an element refers to node {}, which the file does not have", tag));
      number_[tag] = static_cast<std::int64_t>(raw_.points.size() / 3);
      const double* drawn = &points[3 * found->second];
      const std::array<double, 3> x{metres_ * drawn[0], metres_ * drawn[1], metres_ * drawn[2]};
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

  std::vector<std::int64_t> renumber(const std::vector<std::int64_t>& tags) const {
    std::vector<std::int64_t> rows;
    rows.reserve(tags.size());
    for (std::int64_t tag : tags) {
      const auto found = number_.find(tag);
      if (found == number_.end())
        fail(fmt::format("node {} of a boundary element belongs to no cell", tag));
      rows.push_back(found->second);
    }
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

  void require_single_cells() const {
    const int corners = raw_.dim + 1;
    std::vector<Simplex> cells;
    for (std::size_t c = 0; c < raw_.cells.size(); c += corners)
      cells.push_back(simplex(&raw_.cells[c], corners));
    std::ranges::sort(cells);
    if (const auto twice = std::ranges::adjacent_find(cells); twice != cells.end())
      fail(fmt::format("the {} at {} is in the mesh twice, allowed is once", words(raw_.dim).cell,
                       place((*twice)[0])));
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

  void require_facets(const std::string& group, const std::vector<std::int64_t>& facets) const {
    for (std::size_t f = 0; f < facets.size(); f += raw_.dim)
      if (!std::ranges::binary_search(facets_, simplex(&facets[f], raw_.dim), {}, &Facet::nodes))
        fail(fmt::format("the {0} at {1} of the group \"{2}\" is the {0} of no {3}, allowed are {4} of {5}",
                         words(raw_.dim).facet, place(facets[f]), group, words(raw_.dim).cell,
                         words(raw_.dim).facets, words(raw_.dim).cells));
  }

  void groups() {
    gmsh::vectorpair groups;
    gmsh::model::getPhysicalGroups(groups);
    for (const auto& [dim, tag] : groups) {
      const std::string name = group_name(dim, tag);
      if (dim < raw_.dim - 1) {
        raw_.other_groups[name] = dim;
        continue;
      }
      std::vector<int> entities;
      gmsh::model::getEntitiesForPhysicalGroup(dim, tag, entities);
      if (dim == raw_.dim) {
        std::vector<std::int64_t>& part = raw_.parts[name];
        for (int entity : entities)
          if (const auto found = range_.find(entity); found != range_.end())
            part.insert(part.end(), found->second.begin(), found->second.end());
        continue;
      }
      std::vector<std::int64_t>& facets = raw_.facets[name];
      for (int entity : entities) {
        const std::vector<std::int64_t> own = renumber(entity_tags(dim, entity));
        facets.insert(facets.end(), own.begin(), own.end());
      }
      require_facets(name, facets);
    }
  }

  std::string file_;
  double metres_; ///< length of the file's unit
  RawMesh raw_;
  std::unordered_map<std::int64_t, std::int64_t> number_;
  std::map<int, std::array<std::int64_t, 2>> range_; ///< entity → its rows in raw_.cells
  std::vector<Facet> facets_; ///< of every cell, sorted; a facet between two cells appears twice
};

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
    return UserError(fmt::format("{}: gmsh cannot read it: {}", file, said));
  };
  const Session session;
  try {
    gmsh::open(opened);
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
      if (is_to_be_meshed(mesh))
        gmsh::model::mesh::generate(gmsh::model::getDimension());
    }
    if (const std::string error = complaint(""); !error.empty())
      throw cannot_read(error);
    RawMesh raw = Extraction(mesh).run();
    if (!msh && !meshing.keep.empty()) {
      gmsh::option::setNumber("Mesh.Binary", 1);
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
