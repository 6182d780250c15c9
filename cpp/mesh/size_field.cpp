// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/size_field.h"
#include "base/collective.h"
#include "mesh/simplex.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/mesh/Mesh.h>
#include <numeric>

namespace signorini::mesh {

namespace {

/// Edge of the regular simplex of this area or volume.
double edge_of(int dim, double volume) {
  return dim == 2 ? std::sqrt(4 / std::sqrt(3.0) * volume) : std::cbrt(12 / std::sqrt(2.0) * volume);
}

double volume_of(const SizeField& field, std::size_t cell) {
  const std::int64_t* corners = &field.cells[cell * (static_cast<std::size_t>(field.dim) + 1)];
  const Simplex simplex(field.dim,
                        [&](int i) { return &field.points[3 * static_cast<std::size_t>(corners[i])]; });
  return simplex.volume() / (field.dim == 2 ? 2 : 6);
}

} // namespace

SizeField gathered(const Mesh& mesh, std::span<const double> numbers, std::vector<double>& all) {
  const auto& geometry = mesh.dolfinx()->geometry();
  const auto dofmap = geometry.dofmap();
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

SizeField sizes_by(const Mesh& mesh, std::span<const double> indicators, double reduction, double reach) {
  std::vector<double> error;
  SizeField field = gathered(mesh, indicators, error);
  if (rank(mesh.comm()) != 0)
    return {};
  const int dim = field.dim;
  const auto corners = static_cast<std::size_t>(dim) + 1;
  const std::size_t count = error.size(), nodes = field.points.size() / 3;
  std::vector<double> edge(count);
  // Means over the cells at a node: one cell's indicator is noise.
  std::vector<double> errors(nodes), scales(nodes), old(nodes), touching(nodes);
  const auto each_corner = [&](auto&& take) {
    for (std::size_t cell = 0; cell < count; ++cell)
      for (std::size_t i = 0; i < corners; ++i)
        take(cell, static_cast<std::size_t>(field.cells[cell * corners + i]));
  };
  for (std::size_t cell = 0; cell < count; ++cell)
    edge[cell] = edge_of(dim, volume_of(field, cell));
  each_corner([&](std::size_t cell, std::size_t node) {
    errors[node] += error[cell];
    scales[node] += std::pow(edge[cell], dim + 2);
    old[node] += edge[cell];
    touching[node] += 1;
  });
  std::vector<double> density(nodes);
  for (std::size_t node = 0; node < nodes; ++node) {
    old[node] /= touching[node];
    density[node] = errors[node] / scales[node];
  }
  const double least = 1e-12 * std::ranges::max(density); // where nothing is in error
  const auto set = [&](double factor) {
    field.sizes.resize(nodes);
    for (std::size_t node = 0; node < nodes; ++node)
      field.sizes[node] = std::clamp(factor * std::pow(std::max(density[node], least), -1.0 / (dim + 2)),
                                     old[node] / reach, old[node] * reach);
    constexpr double growth = 1.0 / 3;
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t cell = 0; cell < count; ++cell)
        for (std::size_t i = 0; i < corners; ++i)
          for (std::size_t j = 0; j < corners; ++j) {
            const auto a = static_cast<std::size_t>(field.cells[cell * corners + i]),
                       b = static_cast<std::size_t>(field.cells[cell * corners + j]);
            const double *x = &field.points[3 * a], *y = &field.points[3 * b];
            const double most = field.sizes[a] + growth * std::hypot(x[0] - y[0], x[1] - y[1], x[2] - y[2]);
            constexpr double rounding = 1e-9;
            if (field.sizes[b] > most * (1 + rounding))
              field.sizes[b] = most, changed = true;
          }
    }
  };
  const double whole = std::accumulate(error.begin(), error.end(), 0.0);
  if (!(whole > 0)) {
    field.sizes = old;
    return field;
  }
  const auto left = [&] {
    double sum = 0;
    each_corner([&](std::size_t cell, std::size_t node) {
      const double part = field.sizes[node] / edge[cell];
      sum += error[cell] * part * part / static_cast<double>(corners);
    });
    return sum;
  };
  // Bisection of the factor, by its logarithm.
  double low = 0, high = 0;
  for (std::size_t node = 0; node < nodes; ++node) {
    const double neutral = std::log(old[node]) + std::log(std::max(density[node], least)) / (dim + 2);
    low = node == 0 ? neutral : std::min(low, neutral);
    high = node == 0 ? neutral : std::max(high, neutral);
  }
  low -= std::log(reach), high += std::log(reach);
  constexpr int halvings = 40;
  for (int i = 0; i < halvings; ++i) {
    const double middle = (low + high) / 2;
    set(std::exp(middle));
    (left() > reduction * whole ? high : low) = middle;
  }
  return field;
}

} // namespace signorini::mesh
