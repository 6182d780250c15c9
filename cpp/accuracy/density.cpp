// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/density.h"
#include "base/collective.h"
#include "base/error.h"
#include "mesh/gmsh_process.h"
#include <algorithm>
#include <fmt/format.h>
#include <functional>

namespace signorini::accuracy {

std::int64_t cells(MPI_Comm comm, const scene::Mesh& mesh) {
  std::int64_t count = 0;
  on_root(comm, [&] {
    const mesh::RawMesh raw = mesh::read_gmsh(mesh);
    count = static_cast<std::int64_t>(raw.cells.size()) / (raw.dim + 1);
  });
  MPI_Bcast(&count, 1, MPI_INT64_T, 0, comm);
  return count;
}

namespace {

/// At an element size, or at a scale of those that the .geo sets.
std::int64_t cells(MPI_Comm comm, scene::Mesh mesh, double size) {
  (mesh.size ? *mesh.size : mesh.scale) = size;
  return accuracy::cells(comm, mesh);
}

UserError no_answer(const scene::Scene& scene, double coarse, double fine, std::int64_t cells,
                    const char* allowed) {
  const char* kind = scene.mesh.size ? "size" : "scale";
  return UserError(fmt::format(
      "mesh.{0}: {1} has {2} cells at {0} {3:g} and at {0} {4:g}, so that it sets its own density (as "
      "Transfinite curves do); allowed are {5}",
      kind, scene.mesh.file.string(), cells, coarse, fine, allowed));
}

} // namespace

void require_answer_to(MPI_Comm comm, const scene::Scene& scene, const std::vector<double>& sizes) {
  std::vector<double> coarsest = sizes;
  std::ranges::sort(coarsest, std::greater());
  const auto [last, end] = std::ranges::unique(coarsest);
  coarsest.erase(last, end);
  if (coarsest.size() < 2)
    return;
  const std::int64_t coarse = cells(comm, scene.mesh, coarsest[0]),
                     fine = cells(comm, scene.mesh, coarsest[1]);
  if (coarse == fine)
    throw no_answer(scene, coarsest[0], coarsest[1], coarse, "--sizes that change the mesh, or one alone");
}

void require_answer(MPI_Comm comm, const scene::Scene& scene) {
  const double size = scene.mesh.size.value_or(scene.mesh.scale);
  const std::int64_t own = cells(comm, scene.mesh, size);
  // The coarser mesh first: it is quicker to make, but where the body's own edges limit it the finer one
  // decides.
  if (own == cells(comm, scene.mesh, 2 * size) && own == cells(comm, scene.mesh, size / 2))
    throw no_answer(scene, 2 * size, size / 2, own, "a .geo whose mesh they change");
}

} // namespace signorini::accuracy
