// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/wave_time.h"
#include "base/dolfinx_versions.h"
#include "fem/coherence.h"
#include "fem/forms.h"
#include "mesh/simplex.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/mesh/Mesh.h>
#include <limits>

namespace signorini::fem {
namespace {

/// Selects cells by local index: those with a facet on one of the surfaces, or all cells if there are no
/// surfaces.
std::vector<bool> cells_at(const mesh::Mesh& mesh, const std::vector<Surface>& surfaces) {
  const auto topology = mesh.dolfinx()->topology();
  const auto map = topology->index_map(mesh.dim());
  std::vector<bool> wanted(static_cast<std::size_t>(map->size_local() + map->num_ghosts()), surfaces.empty());
  for (const Surface& surface : surfaces)
    for (const std::int32_t facet : mesh.facets(surface.group, surface.key))
      for (const std::int32_t cell : topology->connectivity(mesh.dim() - 1, mesh.dim())->links(facet))
        wanted[static_cast<std::size_t>(cell)] = true;
  return wanted;
}

/// Least height of a cell, m.
double least_height(const mesh::Mesh& mesh, std::int32_t cell) {
  const mesh::Simplex simplex(mesh.dim(), dolfinx_versions::vertices(mesh.dolfinx()->geometry(), cell));
  double steepest = 0;
  for (int i = 0; i <= mesh.dim(); ++i) {
    const auto slope = simplex.gradient(i);
    steepest = std::max(steepest, std::hypot(slope[0], slope[1], slope[2]));
  }
  return 1 / steepest;
}

} // namespace

std::array<double, 2> wave_speeds(const scene::Material& material, scene::PlaneModel model) {
  const auto [young, nu] = material.instantaneous_constants();
  const double shear = young / (2 * (1 + nu)) / material.density;
  const double pressure =
      model == scene::PlaneModel::plane_stress ? shear * 2 / (1 - nu) : shear * 2 * (1 - nu) / (1 - 2 * nu);
  return {std::sqrt(pressure), std::sqrt(shear)};
}

double crossing_time(const Space& space, const std::vector<scene::Material>& materials) {
  double fastest = 0;
  for (const scene::Material& material : materials)
    fastest = std::max(fastest, wave_speeds(material, space.mesh().model())[0]);
  return longest_side(space) / fastest;
}

double least_wave_time(const Space& space, const std::vector<scene::Material>& materials,
                       const std::vector<Surface>& surfaces) {
  const std::vector<bool> wanted = cells_at(space.mesh(), surfaces);
  double least = std::numeric_limits<double>::infinity();
  for (const Part& part : parts(space.mesh(), materials)) {
    const double speed = wave_speeds(part.material, space.mesh().model())[0];
    for (const std::int32_t cell : part.cells)
      if (wanted[static_cast<std::size_t>(cell)])
        least = std::min(least, least_height(space.mesh(), cell) / speed);
  }
  MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_DOUBLE, MPI_MIN, space.comm());
  return least / space.degree();
}

} // namespace signorini::fem
