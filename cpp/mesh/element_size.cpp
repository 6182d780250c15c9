// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/element_size.h"
#include "base/error.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <gmsh.h>
#include <vector>

namespace signorini::mesh {

void set_size(double size) {
  gmsh::option::setNumber("Mesh.MeshSizeMin", size);
  gmsh::option::setNumber("Mesh.MeshSizeMax", size);
}

void set_coarsest_size() {
  constexpr double parts = 10;
  std::array<double, 6> box{};
  gmsh::model::getBoundingBox(-1, -1, box[0], box[1], box[2], box[3], box[4], box[5]);
  set_size(std::max({box[3] - box[0], box[4] - box[1], box[5] - box[2]}) / parts);
}

void set_sizes(const SizeField& field, double metres) {
  const auto corners = static_cast<std::size_t>(field.dim) + 1;
  std::vector<double> data; // of each cell x of its corners, y, z, sizes
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
  // The field alone tells.
  for (const char* other : {"Mesh.MeshSizeExtendFromBoundary", "Mesh.MeshSizeFromPoints",
                            "Mesh.MeshSizeFromCurvature", "Mesh.MeshSizeFromParametricPoints"})
    gmsh::option::setNumber(other, 0);
}

namespace {

/// Area or volume of the current model by a mesh of elements of this size, in the unit of the file.
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

} // namespace

void require_few_cells(const scene::Mesh& mesh, const std::string& opened) {
  constexpr double most = 1e8, doubtful = 1e7;
  const int dim = gmsh::model::getDimension();
  if (dim < 2)
    return;
  std::array<double, 6> box{};
  gmsh::model::getBoundingBox(-1, -1, box[0], box[1], box[2], box[3], box[4], box[5]);
  std::array<double, 3> sides{box[3] - box[0], box[4] - box[1], box[5] - box[2]};
  constexpr double coarsest = 10; // times the body
  if (const double longest = scene::metres(mesh.unit) * std::ranges::max(sides);
      *mesh.size > coarsest * longest)
    throw UserError(
        fmt::format("mesh.size: found {:.4g} m, allowed is at most {:.3g} m for a body of {:.3g} m; "
                    "the size is in metres, whatever mesh.unit is",
                    *mesh.size, coarsest * longest, longest));
  const double metres = scene::metres(mesh.unit), size = *mesh.size / metres,
               cell = std::pow(size, dim) *
                      (dim == 2 ? std::sqrt(3.0) / 4 : std::sqrt(2.0) / 12); // regular ones
  if (!(sides[0] * sides[1] * (dim == 3 ? sides[2] : 1) > doubtful * cell))
    return;
  const double cells = measure(dim, std::max({sides[0], sides[1], sides[2]}) / (dim == 2 ? 20 : 8)) / cell;
  if (!(cells <= most))
    throw UserError(fmt::format("mesh.size: found {:.4g} m, which makes some {:.1e} cells of a body of "
                                "{:.3g} m, allowed are sizes that make "
                                "no more than {:.0e}; a file in millimetres has mesh.unit = \"mm\"",
                                *mesh.size, cells, metres * std::max({sides[0], sides[1], sides[2]}), most));
  gmsh::clear();
  gmsh::logger::stop(); // what it says of the coarse mesh is no matter
  gmsh::logger::start();
  gmsh::open(opened);
}

} // namespace signorini::mesh
