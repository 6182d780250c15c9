// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "mesh/raw_mesh.h"
#include <concepts>
#include <memory>
#include <mpi.h>

namespace dolfinx::mesh {
template <std::floating_point T>
class Mesh;
}

namespace signorini::mesh {

/// Distributes a mesh from rank 0 over the ranks of a communicator; `dim` is given on every rank. Its input
/// numbers are the rows of `raw`. Collective.
std::shared_ptr<dolfinx::mesh::Mesh<double>> distributed(MPI_Comm comm, const RawMesh& raw, int dim);

} // namespace signorini::mesh
