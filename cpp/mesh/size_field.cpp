// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/size_field.h"
#include "base/collective.h"
#include "base/dolfinx_versions.h"
#include "base/point.h"
#include "mesh/facets.h"
#include "mesh/simplex.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/mesh/Mesh.h>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>

namespace signorini::mesh {

namespace {

/// Edge length of the regular triangle or tetrahedron with this area or volume.
double edge_of(int dim, double volume) {
  return dim == 2 ? std::sqrt(4 / std::sqrt(3.0) * volume) : std::cbrt(12 / std::sqrt(2.0) * volume);
}

double volume_of(const SizeField& field, std::size_t cell) {
  const std::int64_t* corners = &field.cells[cell * (static_cast<std::size_t>(field.dim) + 1)];
  const Simplex simplex(field.dim,
                        [&](int i) { return &field.points[3 * static_cast<std::size_t>(corners[i])]; });
  return simplex.abs_determinant() / (field.dim == 2 ? 2 : 6);
}

Point point(const SizeField& field, std::size_t node) {
  const double* x = &field.points[3 * node];
  return {x[0], x[1], x[2]};
}

} // namespace

SizeField gather_cells(const Mesh& mesh, std::span<const double> numbers, std::vector<double>& all) {
  const auto& geometry = mesh.dolfinx()->geometry();
  const auto dofmap = dolfinx_versions::cell_nodes(geometry);
  const auto corners = static_cast<std::size_t>(mesh.dim()) + 1;
  std::vector<std::int64_t> cells;
  std::vector<std::int32_t> local;
  for (const std::int32_t cell : mesh.owned_cells())
    for (std::size_t i = 0; i < corners; ++i)
      local.push_back(dofmap(cell, i));
  cells.resize(local.size());
  geometry.index_map()->local_to_global(local, cells);
  const auto owned = static_cast<std::size_t>(geometry.index_map()->size_local());
  const MPI_Comm comm = mesh.comm();
  SizeField field{.dim = mesh.dim()};
  field.points = gather(comm, std::vector<double>(geometry.x().begin(), geometry.x().begin() + 3 * owned));
  field.cells = gather(comm, cells);
  all = gather(comm, std::vector<double>(numbers.begin(), numbers.end()));
  return field;
}

std::vector<double> volumes(const SizeField& field) {
  std::vector<double> all(field.cells.size() / (static_cast<std::size_t>(field.dim) + 1));
  for (std::size_t cell = 0; cell < all.size(); ++cell)
    all[cell] = volume_of(field, cell);
  return all;
}

double count_of(const SizeField& field) {
  const auto corners = static_cast<std::size_t>(field.dim) + 1;
  const std::vector<double> volume = volumes(field);
  double sum = 0;
  for (std::size_t cell = 0; cell < volume.size(); ++cell)
    for (std::size_t i = 0; i < corners; ++i) {
      const double size = field.sizes[static_cast<std::size_t>(field.cells[cell * corners + i])];
      sum += std::pow(edge_of(field.dim, volume[cell]) / size, field.dim) / static_cast<double>(corners);
    }
  return sum;
}

void limit_growth(SizeField& field) {
  constexpr double growth = 1.0 / 3, rounding = 1e-9;
  const auto corners = static_cast<std::size_t>(field.dim) + 1;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t first = 0; first < field.cells.size(); first += corners)
      for (std::size_t i = 0; i < corners; ++i)
        for (std::size_t j = 0; j < corners; ++j) {
          const auto a = static_cast<std::size_t>(field.cells[first + i]),
                     b = static_cast<std::size_t>(field.cells[first + j]);
          const double most = field.sizes[a] + growth * length(from(point(field, a), point(field, b)));
          if (field.sizes[b] > most * (1 + rounding))
            field.sizes[b] = most, changed = true;
        }
  }
}

void limit_by_curvature(SizeField& field, double around) {
  constexpr double corner = 30 * std::numbers::pi / 180;
  struct Facet {
    Point normal, middle;
  };
  std::map<std::vector<std::int64_t>, std::vector<Facet>>
      ridges; // in the boundary: points in the plane, edges
  for (const auto& [sorted, opposite] : outer_facets(sorted_facets(field.dim, field.cells))) {
    const std::vector<std::int64_t> nodes(sorted.begin(), sorted.begin() + field.dim);
    std::vector<Point> at;
    Point middle{};
    for (const std::int64_t node : nodes) {
      at.push_back(point(field, static_cast<std::size_t>(node)));
      middle = along(middle, 1.0 / static_cast<double>(nodes.size()), at.back());
    }
    const Point edge = from(at[0], at[1]);
    Point normal = field.dim == 2 ? Point{-edge[1], edge[0], 0} : cross(edge, from(at[0], at[2]));
    const double inwards = dot(normal, from(middle, point(field, static_cast<std::size_t>(opposite))));
    normal = scaled((inwards > 0 ? -1 : 1) / length(normal), normal);
    for (std::size_t left_out = 0; left_out < nodes.size(); ++left_out) {
      std::vector<std::int64_t> ridge = nodes;
      ridge.erase(ridge.begin() + static_cast<std::ptrdiff_t>(left_out));
      ridges[ridge].push_back({normal, middle});
    }
  }
  for (const auto& [nodes, facets] : ridges) {
    if (facets.size() != 2)
      continue;
    const double turn = std::acos(std::clamp(dot(facets[0].normal, facets[1].normal), -1.0, 1.0)),
                 curvature = turn / length(from(facets[1].middle, facets[0].middle));
    if (!(turn < corner) || !(curvature > 0))
      continue;
    for (const std::int64_t node : nodes) {
      double& size = field.sizes[static_cast<std::size_t>(node)];
      size = std::min(size, 2 * std::numbers::pi / (curvature * around));
    }
  }
}

std::string geo_with_sizes(const SizeField& field, const std::filesystem::path& body, double metres) {
  const auto corners = static_cast<std::size_t>(field.dim) + 1;
  std::string text = fmt::format("// Sizes that vary, for the body of another file.\nInclude \"{}\";\n"
                                 "View \"sizes\" {{\n",
                                 body.string());
  for (std::size_t first = 0; first < field.cells.size(); first += corners) {
    text += field.dim == 2 ? "ST(" : "SS(";
    for (std::size_t i = 0; i < corners; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis)
        text +=
            fmt::format("{}{:.9g}", i + axis == 0 ? "" : ",",
                        field.points[3 * static_cast<std::size_t>(field.cells[first + i]) + axis] / metres);
    for (std::size_t i = 0; i < corners; ++i)
      text += fmt::format("{}{:.4g}", i == 0 ? "){" : ",",
                          field.sizes[static_cast<std::size_t>(field.cells[first + i])] / metres);
    text += "};\n";
  }
  return text + fmt::format("}};\n"
                            "signorini_sizes = newf;\n"
                            "Field[signorini_sizes] = PostView;\n"
                            "Field[signorini_sizes].ViewIndex = PostProcessing.NbViews - 1;\n"
                            "Background Field = signorini_sizes;\n"
                            "Mesh.MeshSizeExtendFromBoundary = 0;\n"
                            "Mesh.MeshSizeFromPoints = 0;\n"
                            "Mesh.MeshSizeFromParametricPoints = 0;\n"
                            "Mesh.MeshSizeFromCurvature = 0;\n");
}

SizeField sizes_by(const Mesh& mesh, std::span<const double> indicators, double reduction, double reach) {
  std::vector<double> error;
  SizeField field = gather_cells(mesh, indicators, error);
  return rank(mesh.comm()) == 0 ? sizes_by(std::move(field), error, reduction, reach) : SizeField{};
}

namespace {

/// Calls take(cell, node) for each corner of each cell.
template <class Take>
void for_each_corner(const SizeField& field, Take&& take) {
  const auto corners = static_cast<std::size_t>(field.dim) + 1;
  for (std::size_t i = 0; i < field.cells.size(); ++i)
    take(i / corners, static_cast<std::size_t>(field.cells[i]));
}

/// Means over the cells at each node, which are smoother than the indicators of single cells.
struct NodeMeans {
  std::vector<double> size,
      density; ///< edge length, m; error per edge^(dim + 2), positive unless the error is zero
};

NodeMeans node_means(const SizeField& field, const std::vector<double>& error,
                     const std::vector<double>& edge) {
  const std::size_t nodes = field.points.size() / 3;
  std::vector<double> errors(nodes), scales(nodes), touching(nodes);
  NodeMeans means{.size = std::vector<double>(nodes), .density = std::vector<double>(nodes)};
  for_each_corner(field, [&](std::size_t cell, std::size_t node) {
    errors[node] += error[cell];
    scales[node] += std::pow(edge[cell], field.dim + 2);
    means.size[node] += edge[cell];
    touching[node] += 1;
  });
  for (std::size_t node = 0; node < nodes; ++node) {
    means.size[node] /= touching[node];
    means.density[node] = errors[node] / scales[node];
  }
  const double least = 1e-12 * std::ranges::max(means.density); // where nothing is in error
  for (double& density : means.density)
    density = std::max(density, least);
  return means;
}

} // namespace

SizeField sizes_by(SizeField field, const std::vector<double>& error, double reduction, double reach) {
  const int dim = field.dim;
  const std::size_t nodes = field.points.size() / 3;
  std::vector<double> edge(error.size());
  for (std::size_t cell = 0; cell < edge.size(); ++cell)
    edge[cell] = edge_of(dim, volume_of(field, cell));
  const auto [old, density] = node_means(field, error, edge);
  const double whole = std::accumulate(error.begin(), error.end(), 0.0);
  field.sizes = old;
  if (!(whole > 0))
    return field;
  // Bisection of the factor of the sizes, by its logarithm.
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::size_t node = 0; node < nodes; ++node) {
    const double neutral = std::log(old[node]) + std::log(density[node]) / (dim + 2);
    low = std::min(low, neutral);
    high = std::max(high, neutral);
  }
  low -= std::log(reach), high += std::log(reach);
  constexpr int halvings = 40;
  for (int i = 0; i < halvings; ++i) {
    const double middle = (low + high) / 2, factor = std::exp(middle);
    for (std::size_t node = 0; node < nodes; ++node)
      field.sizes[node] = std::clamp(factor * std::pow(density[node], -1.0 / (dim + 2)), old[node] / reach,
                                     old[node] * reach);
    limit_growth(field);
    double left = 0; // part of the error
    for_each_corner(field, [&](std::size_t cell, std::size_t node) {
      const double part = field.sizes[node] / edge[cell];
      left += error[cell] * part * part / static_cast<double>(dim + 1);
    });
    (left > reduction * whole ? high : low) = middle;
  }
  return field;
}

} // namespace signorini::mesh
