// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh_model.h"
#include "base/error.h"
#include "mesh/gmsh_cells.h"
#include "mesh/gmsh_shapes.h"
#include "mesh/size_field.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <gmsh.h>
#include <iterator>
#include <span>
#include <string_view>

namespace signorini::mesh {
namespace {

using Tag = std::size_t;

/// Scope guard that initialises and finalises gmsh, whose state is process-wide, for one file.
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

/// First error message of gmsh, since its exceptions often contain only the last; `fallback` if gmsh logged
/// none.
std::string complaint(const std::string& fallback) {
  std::vector<std::string> log;
  gmsh::logger::get(log);
  for (const std::string& line : log)
    if (line.starts_with("Error: "))
      return line.substr(7);
  return fallback;
}

/// Sets one size for all elements, in the unit of the file.
void set_size(double size) {
  gmsh::option::setNumber("Mesh.MeshSizeMin", size);
  gmsh::option::setNumber("Mesh.MeshSizeMax", size);
}

/// Sides of the bounding box of gmsh's current model, in the unit of the file.
std::array<double, 3> sides_of_model() {
  std::array<double, 6> box{};
  gmsh::model::getBoundingBox(-1, -1, box[0], box[1], box[2], box[3], box[4], box[5]);
  return {box[3] - box[0], box[4] - box[1], box[5] - box[2]};
}

/// Sets the size of all elements for automatic mesh.size: a tenth of the body's longest side.
void set_coarsest_size() {
  constexpr double parts = 10;
  set_size(std::ranges::max(sides_of_model()) / parts);
}

/// Makes gmsh use the sizes (m) of a field as its only sizes; `metres`: length of the file's unit, m.
void set_sizes(const SizeField& field, double metres) {
  const auto corners = static_cast<std::size_t>(field.dim) + 1;
  std::vector<double> data; // for each cell x of its corners, y, z, sizes
  data.reserve(field.cells.size() * 4);
  for (std::size_t first = 0; first < field.cells.size(); first += corners) {
    const auto node = [&](std::size_t i) { return static_cast<std::size_t>(field.cells[first + i]); };
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t i = 0; i < corners; ++i)
        data.push_back(field.points[3 * node(i) + axis] / metres);
    for (std::size_t i = 0; i < corners; ++i)
      data.push_back(field.sizes[node(i)] / metres);
  }
  const int view = gmsh::view::add("sizes");
  gmsh::view::addListData(view, field.dim == 2 ? "ST" : "SS", static_cast<int>(field.cells.size() / corners),
                          data);
  const int sizes = gmsh::model::mesh::field::add("PostView");
  gmsh::model::mesh::field::setNumber(sizes, "ViewTag", view);
  gmsh::model::mesh::field::setAsBackgroundMesh(sizes);
  // Only the field sets sizes.
  for (const char* other : {"Mesh.MeshSizeExtendFromBoundary", "Mesh.MeshSizeFromPoints",
                            "Mesh.MeshSizeFromCurvature", "Mesh.MeshSizeFromParametricPoints"})
    gmsh::option::setNumber(other, 0);
}

/// Area or volume of gmsh's current model, computed with a mesh of elements of this size; all in the unit of
/// the file.
double measure(int dim, double size) {
  set_size(size);
  gmsh::model::mesh::generate(dim);
  std::vector<int> types;
  std::vector<std::vector<std::size_t>> elements, nodes;
  gmsh::model::mesh::getElements(types, elements, nodes, dim);
  double sum = 0;
  for (const std::vector<std::size_t>& block : elements) {
    std::vector<double> volumes;
    gmsh::model::mesh::getElementQualities(block, volumes, "volume");
    for (double volume : volumes)
      sum += std::abs(volume);
  }
  return sum;
}

/// Throws UserError if mesh.size is ten times larger than the body or would result in more than 1e8 cells,
/// for which gmsh would need hours. `opened`: file from which the current model was just read. Where the
/// bounding box is inconclusive, a coarse mesh measures the body.
void require_few_cells(const scene::Mesh& mesh, const std::string& opened) {
  constexpr double most = 1e8, suspicious = 1e7;
  const int dim = gmsh::model::getDimension();
  if (dim < 2)
    return;
  const std::array<double, 3> sides = sides_of_model();
  const double metres = mesh.metres(), longest = std::ranges::max(sides);
  constexpr double coarsest = 10; // times the body
  if (*mesh.size > coarsest * (metres * longest))
    throw UserError(fmt::format("mesh.size: found {:.4g} m; expected at most {:.3g} m for a body of {:.3g} m "
                                "(mesh.size is in metres for every mesh.unit)",
                                *mesh.size, coarsest * (metres * longest), metres * longest));
  const double size = *mesh.size / metres,
               cell = std::pow(size, dim) *
                      (dim == 2 ? std::sqrt(3.0) / 4 : std::sqrt(2.0) / 12); // regular ones
  if (!(sides[0] * sides[1] * (dim == 3 ? sides[2] : 1) > suspicious * cell))
    return;
  const double cells = measure(dim, longest / (dim == 2 ? 20 : 8)) / cell;
  if (!(cells <= most))
    throw UserError(fmt::format("mesh.size: found {:.4g} m, which gives about {:.1e} cells for a body of "
                                "{:.3g} m. The limit is {:.0e} cells (a file in millimetres needs mesh.unit "
                                "= \"mm\")",
                                *mesh.size, cells, metres * longest, most));
  gmsh::clear();
  gmsh::logger::stop(); // messages on the coarse mesh do not matter
  gmsh::logger::start();
  gmsh::open(opened);
}

/// Resets the options of a .geo that select cells other than straight simplices, and returns a note for each
/// option that was set. Cells are always straight, and the degree comes from the scene.
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

/// Throws UserError for a .geo whose last line has several statements and no line end, since gmsh silently
/// drops all statements of such a line but the first.
void require_last_line(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::string last = text.substr(text.find_last_of('\n') + 1); // npos + 1 is 0
  const std::size_t first = last.find(';');
  const std::size_t next = first == std::string::npos ? first : last.find_first_not_of(" \t\r", first + 1);
  if (next != std::string::npos && last.compare(next, 2, "//") != 0)
    throw UserError(
        fmt::format("{}: the last line has several statements but no newline, so gmsh reads only the first; "
                    "add a newline",
                    file));
}

/// Reads a CAD file again, with solids made of its faces, if it has faces in space alone, as many .iges have.
void make_solids(const std::string& file) {
  const std::array<double, 3> sides = sides_of_model();
  constexpr double flat = 1e-6; // more than the tolerance by which boxes are larger
  if (gmsh::model::getDimension() != 2 || sides[2] < flat * std::max(sides[0], sides[1]))
    return;
  gmsh::clear();
  gmsh::option::setNumber("Geometry.OCCSewFaces", 1);
  gmsh::option::setNumber("Geometry.OCCMakeSolids", 1);
  gmsh::open(file);
}

/// Joins the partitions of a mesh and drops their ghost cells, which are copies.
void join_partitions() {
  if (gmsh::model::getNumberOfPartitions() > 0)
    gmsh::model::mesh::unpartition();
}

/// Throws UserError if gmsh has dropped elements or nodes, which happens if two of them have the same number.
void require_all(const MshFile& msh, const std::string& file) {
  std::vector<int> types;
  std::vector<std::vector<Tag>> elements, nodes;
  gmsh::model::mesh::getElements(types, elements, nodes);
  std::size_t read = 0;
  for (const auto& block : elements)
    read += block.size();
  if (read < msh.elements())
    throw UserError(
        fmt::format("{}: announces {} elements, but has only {} different element numbers; renumber them",
                    file, msh.elements(), read));
  std::vector<std::string> log;
  gmsh::logger::get(log);
  constexpr std::string_view dropped = "Skipping duplicate node ";
  for (const std::string& line : log)
    if (const std::size_t at = line.find(dropped); at != std::string::npos)
      throw UserError(fmt::format("{}: node number {} occurs twice; renumber the nodes", file,
                                  line.substr(at + dropped.size())));
}

/// Returns whether gmsh has to mesh the model of a .geo. Removes a mesh that the .geo has generated itself
/// (Mesh 2; Save …), since gmsh would keep it for every size. Returns false if the model has only a mesh, for
/// example one that the .geo merges. Throws UserError if it has only a mesh and the scene sets a size.
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
                                "remove mesh.size, or use a .geo with a geometry",
                                mesh.file.string()));
  return !discrete;
}

/// Number of elements on the curves of gmsh's current model.
std::size_t elements_on_curves() {
  std::vector<int> types;
  std::vector<std::vector<Tag>> elements, nodes;
  gmsh::model::mesh::getElements(types, elements, nodes, 1);
  std::size_t count = 0;
  for (const std::vector<Tag>& block : elements)
    count += block.size();
  return count;
}

/// Returns notes on a size of the scene that changes no curve of the current mesh, which is lost: the curves
/// are divided again, with a quarter of the size.
std::vector<std::string> notes_on_size(const scene::Mesh& mesh) {
  if (mesh.format() != scene::MeshFormat::script || mesh.automatic() || (!mesh.size && mesh.scale == 1))
    return {};
  constexpr double finer = 4;
  const std::size_t before = elements_on_curves();
  gmsh::model::mesh::clear();
  if (mesh.size)
    set_size(std::min(*mesh.size / mesh.metres(), std::ranges::max(sides_of_model())) / finer);
  else
    gmsh::option::setNumber("Mesh.MeshSizeFactor", mesh.scale / finer);
  try {
    gmsh::model::mesh::generate(1);
  } catch (const std::exception&) { // of a size that nobody asked for
    return {};
  }
  if (before == 0 || elements_on_curves() != before)
    return {};
  return {fmt::format("mesh.{} has no effect on {}: the file sets its own mesh density, for example by "
                      "Transfinite curves",
                      mesh.size ? "size" : "scale", mesh.file.filename().string())};
}

} // namespace

RawMesh read_gmsh_here(const scene::Mesh& mesh, const Meshing& meshing,
                       const std::optional<std::string>& converted) {
  const std::string file = mesh.file.string();
  if (!std::ifstream(file) || std::filesystem::is_directory(mesh.file))
    throw UserError(fmt::format("mesh.file: {} cannot be read; give the path of a mesh or a geometry", file));
  std::optional<MshFile> msh;
  if (converted)
    msh.emplace(file, *converted);
  else if (mesh.format() == scene::MeshFormat::msh)
    msh.emplace(mesh.file);
  const std::string opened = msh ? msh->path() : file;
  const auto cannot_read = [&](std::string said) {
    if (const std::size_t at = said.find(opened); at != std::string::npos)
      said.replace(at, opened.size(), file);
    return UserError(fmt::format("{}: gmsh cannot read it: {}{}", file, said,
                                 msh ? "; write the file again, with gmsh or as MSH 2.2"
                                 : mesh.format() == scene::MeshFormat::script
                                     ? ""
                                     : "; check that the file is complete"));
  };
  const Session session;
  std::vector<std::string> notes;
  bool meshed_here = false;
  try {
    const bool groups_per_cell = msh && msh->version() < 3;
    if (groups_per_cell) // read by groups: entities may be anything, such as all of them 1
      gmsh::option::setNumber("Mesh.SwitchElementTags", 1);
    if (mesh.format() == scene::MeshFormat::script)
      require_last_line(file);
    gmsh::open(opened);
    if (mesh.format() == scene::MeshFormat::shape)
      make_solids(opened);
    join_partitions();
    if (!mesh.meshed()) {
      const double metres = mesh.metres();
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
      meshed_here = is_to_be_meshed(mesh);
      if (meshed_here) {
        if (mesh.format() == scene::MeshFormat::shape)
          group_shapes();
        gmsh::model::mesh::generate(gmsh::model::getDimension());
      }
    }
    if (const std::string error = complaint(""); !error.empty())
      throw cannot_read(error);
    if (msh)
      require_all(*msh, file);
    RawMesh raw =
        with_groups(GmshCells(mesh, groups_per_cell), msh ? msh->group_names() : MshFile::GroupNames());
    raw.notes.insert(raw.notes.end(), notes.begin(), notes.end());
    if (!msh && !meshing.keep.empty()) {
      gmsh::option::setNumber("Mesh.Binary", 1);
      gmsh::option::setNumber("Mesh.SaveAll", 1); // elements in no group too
      gmsh::write(meshing.keep.string());
    }
    if (meshed_here && !meshing.sizes)
      std::ranges::move(notes_on_size(mesh), std::back_inserter(raw.notes));
    return raw;
  } catch (const UserError&) {
    throw;
  } catch (const std::exception& error) {
    throw cannot_read(complaint(error.what()));
  }
}

namespace {

/// Adds the elements and groups of one dimension to gmsh's model. Elements with the same groups form one
/// entity.
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
  // All nodes belong to one entity, which has nothing else.
  gmsh::model::mesh::addNodes(mesh.dim, gmsh::model::addDiscreteEntity(mesh.dim), tags, points);
  std::vector<std::vector<std::string>> groups(mesh.cells.size() / (dim + 1));
  for (const auto& [name, ranges] : mesh.parts)
    for (std::size_t r = 0; r < ranges.size(); r += 2)
      for (std::int64_t cell = ranges[r]; cell < ranges[r + 1]; ++cell)
        groups[static_cast<std::size_t>(cell)].push_back(name);
  add_entities(mesh.dim, mesh.cells, groups);
  std::map<SortedNodes, std::pair<std::vector<std::int64_t>, std::vector<std::string>>> named;
  for (const auto& [name, facets] : mesh.facets)
    for (std::size_t f = 0; f < facets.size(); f += dim) {
      auto& [nodes, names] = named[sorted_nodes(std::span(facets).subspan(f, dim))];
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
