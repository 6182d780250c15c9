// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/distribution.h"
#include "base/collective.h"
#include "base/dolfinx_versions.h"
#include <cstdlib>
#include <dolfinx/fem/CoordinateElement.h>
#include <dolfinx/mesh/Mesh.h>
#include <dolfinx/mesh/utils.h>
#include <span>

namespace signorini::mesh {

std::shared_ptr<dolfinx::mesh::Mesh<double>> distributed(MPI_Comm comm, const RawMesh& raw, int dim) {
  const auto type = dim == 2 ? dolfinx::mesh::CellType::triangle : dolfinx::mesh::CellType::tetrahedron;
  const dolfinx::fem::CoordinateElement<double> element(type, 1);
  std::vector<double> x;
  for (std::size_t p = 0; p < raw.points.size(); p += 3)
    x.insert(x.end(), &raw.points[p], &raw.points[p] + dim);
  const std::size_t nodes = raw.points.size() / 3;
  // Rank 0, which has all cells, divides them alone and on one thread, unless the user sets more. With
  // several ranks or threads the division depends on timing, and is not reproducible.
  setenv("SCOTCH_PTHREAD_NUMBER", "1", 0);
  MPI_Comm dividing = rank(comm) == 0 ? MPI_COMM_SELF : MPI_COMM_NULL;
  return std::make_shared<dolfinx::mesh::Mesh<double>>(
      dolfinx_versions::create_mesh(comm, dividing, std::span<const std::int64_t>(raw.cells), element, x,
                                    {nodes, static_cast<std::size_t>(dim)}, ranks(comm) > 1));
}

} // namespace signorini::mesh
