#include "mesh/gmsh_model.h"
#include "base/error.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <gmsh.h>
#include <set>
#include <unordered_map>

namespace signorini::mesh {
namespace {

using Tag = std::size_t;

/// gmsh's process-wide state, for as long as one file is read.
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
    } catch (...) { // nothing more can be done about a library that fails to end
    }
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
};

/// gmsh's first complaint: its exceptions often carry only the last.
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

class Extraction {
public:
  explicit Extraction(const scene::Mesh& mesh) : file_(mesh.file.string()) {}

  RawMesh run() {
    require_dimension();
    std::vector<std::int64_t> cells = cell_tags();
    number_points(cells);
    raw_.cells = renumber(cells);
    require_area();
    count_edges();
    boundary_groups();
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
      fail("the mesh has no elements (is the file incomplete?), allowed is a mesh of triangles");
    if (raw_.dim == 3)
      fail("the mesh has volume elements; three dimensions are not available yet, allowed is a mesh of "
           "triangles in the plane z = 0");
    if (raw_.dim < 2)
      fail(fmt::format("the highest elements of the mesh are those of a {}, allowed is a mesh of triangles",
                       kind(raw_.dim)));
    require_straight(raw_.dim, "straight triangles (Triangle 3)");
    require_straight(raw_.dim - 1, "straight edges (Line 2)");
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
  std::vector<std::int64_t> cell_tags() const {
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
        fail(fmt::format("{} {} has {} elements and is in no physical group, allowed are {}s in a group, such "
                         "as: Physical {}(\"body\") = {{{}}};",
                         kind(dim), entity, own.size() / (dim + 1), kind(dim), dim == 2 ? "Surface" : "Volume",
                         entity));
      cells.insert(cells.end(), own.begin(), own.end());
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
    double extent = 0, off_plane = 0;
    for (std::int64_t tag : std::set<std::int64_t>(cells.begin(), cells.end())) {
      const auto found = row.find(static_cast<Tag>(tag));
      if (found == row.end())
        fail(fmt::format("an element refers to node {}, which the file does not have", tag));
      number_[tag] = static_cast<std::int64_t>(raw_.points.size() / 3);
      const double* x = &points[3 * found->second];
      if (!std::isfinite(x[0]) || !std::isfinite(x[1]) || !std::isfinite(x[2]))
        fail(fmt::format("node {} is at ({}, {}, {}), allowed are finite coordinates", tag, x[0], x[1], x[2]));
      raw_.points.insert(raw_.points.end(), x, x + 3);
      extent = std::max({extent, std::abs(x[0]), std::abs(x[1])});
      off_plane = std::max(off_plane, std::abs(x[2]));
    }
    if (off_plane > 1e-12 * extent)
      fail(fmt::format("the triangles leave the plane z = 0 by {} m, allowed is a plane mesh", off_plane));
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

  void require_area() const {
    for (std::size_t c = 0; c < raw_.cells.size(); c += 3) {
      const double *a = &raw_.points[3 * raw_.cells[c]], *b = &raw_.points[3 * raw_.cells[c + 1]],
                   *d = &raw_.points[3 * raw_.cells[c + 2]];
      const double ab = std::hypot(b[0] - a[0], b[1] - a[1]), ad = std::hypot(d[0] - a[0], d[1] - a[1]);
      const double cross = std::abs((b[0] - a[0]) * (d[1] - a[1]) - (b[1] - a[1]) * (d[0] - a[0]));
      if (!(cross > 1e-14 * ab * ad))
        fail(fmt::format("the triangle at ({}, {}) has no area, allowed are triangles with three corners", a[0],
                         a[1]));
    }
  }

  /// Every triangle once, every edge of one or two triangles.
  void count_edges() {
    std::set<std::array<std::int64_t, 3>> triangles;
    for (std::size_t c = 0; c < raw_.cells.size(); c += 3) {
      std::array triangle{raw_.cells[c], raw_.cells[c + 1], raw_.cells[c + 2]};
      std::ranges::sort(triangle);
      const double* x = &raw_.points[3 * triangle[0]];
      if (!triangles.insert(triangle).second)
        fail(fmt::format("the triangle at ({}, {}) is in the mesh twice, allowed is once", x[0], x[1]));
      for (const auto& [i, j] : {std::pair{0, 1}, {0, 2}, {1, 2}})
        if (++edges_[{triangle[i], triangle[j]}] > 2)
          fail(fmt::format("more than two triangles share the edge at ({}, {}), allowed are one or two", x[0], x[1]));
    }
  }

  void require_edges(const std::string& group, const std::vector<std::int64_t>& facets) const {
    for (std::size_t f = 0; f < facets.size(); f += 2)
      if (!edges_.contains(std::minmax(facets[f], facets[f + 1]))) {
        const double* x = &raw_.points[3 * facets[f]];
        fail(fmt::format("the edge at ({}, {}) of the group \"{}\" is the edge of no triangle, allowed are edges of "
                         "triangles",
                         x[0], x[1], group));
      }
  }

  void boundary_groups() {
    gmsh::vectorpair groups;
    gmsh::model::getPhysicalGroups(groups);
    for (const auto& [dim, tag] : groups) {
      const std::string name = group_name(dim, tag);
      if (dim != raw_.dim - 1) {
        raw_.other_groups[name] = dim;
        continue;
      }
      std::vector<int> entities;
      gmsh::model::getEntitiesForPhysicalGroup(dim, tag, entities);
      std::vector<std::int64_t>& facets = raw_.facets[name];
      for (int entity : entities) {
        const std::vector<std::int64_t> own = renumber(entity_tags(dim, entity));
        facets.insert(facets.end(), own.begin(), own.end());
      }
      require_edges(name, facets);
    }
  }

  std::string file_;
  RawMesh raw_;
  std::unordered_map<std::int64_t, std::int64_t> number_;
  std::map<std::pair<std::int64_t, std::int64_t>, int> edges_; ///< node pair, lower first → triangles that have it
};

/// A .msh that was cut short, which gmsh may read as far as it goes.
void require_whole(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::string line, last;
  while (std::getline(in, line))
    if (line.find_first_not_of(" \t\r") != std::string::npos)
      last = line;
  if (last.empty() || last.starts_with("$End"))
    return; // gmsh says what is wrong with an empty file
  throw UserError(fmt::format("{}: not a whole .msh file: its last line is not the end of a section ($End...); allowed are "
                              "complete .msh files",
                              file));
}

} // namespace

RawMesh read_gmsh(const scene::Mesh& mesh) {
  const std::string file = mesh.file.string();
  if (!std::ifstream(file) || std::filesystem::is_directory(mesh.file))
    throw UserError(fmt::format("mesh.file: {} cannot be read, allowed is the path of a .geo or .msh file", file));
  if (mesh.file.extension() == ".msh")
    require_whole(file);
  Session session;
  try {
    gmsh::open(file);
    if (mesh.file.extension() == ".geo") {
      if (mesh.size) {
        gmsh::option::setNumber("Mesh.MeshSizeMin", *mesh.size);
        gmsh::option::setNumber("Mesh.MeshSizeMax", *mesh.size);
      }
      gmsh::model::mesh::generate(gmsh::model::getDimension());
    }
    if (const std::string error = complaint(""); !error.empty())
      throw UserError(fmt::format("{}: gmsh cannot read it: {}", file, error));
    return Extraction(mesh).run();
  } catch (const UserError&) {
    throw;
  } catch (const std::exception& error) {
    throw UserError(fmt::format("{}: gmsh cannot read it: {}", file, complaint(error.what())));
  }
}

} // namespace signorini::mesh
