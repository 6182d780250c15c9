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

/// Distributes the mesh `raw` of rank 0 over the ranks of `comm`. `dim`: dimension of the mesh, passed on
/// every rank. In the result, input_global_indices() and original_cell_index number nodes and cells by their
/// rows in `raw`. Collective.
std::shared_ptr<dolfinx::mesh::Mesh<double>> distributed(MPI_Comm comm, const RawMesh& raw, int dim);

} // namespace signorini::mesh
