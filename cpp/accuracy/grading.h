// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "scene/scene.h"
#include <cstdint>
#include <filesystem>
#include <mpi.h>
#include <vector>

namespace signorini::accuracy {

/// Writes `file`, a .geo with the scene's body and with element sizes that are small where error indicators
/// are large. At mesh.scale = 1 its mesh has about as many elements as the scene's own mesh. If mesh.size is
/// "auto", the mesh has about as many elements as a uniform mesh with ten elements across the body. The
/// indicators come from two motions with elements of degree 1 on coarse meshes. With an objective they are
/// the cells' shares in the adjoint error estimate of J at the control drivers::evaluation_point(). Without
/// one they are the cells' stress errors in the energy norm over all steps, by stress recovery
/// (fem::StressRecovery). At curved boundaries, which elements approximate by a polygon, sizes are limited in
/// proportion to the radius of curvature. If this is half the body's extent, the limit is 1.5 times the size
/// of a uniform mesh with as many elements. Throws UserError, SolverFailure, Interrupted. Collective.
void write_graded(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& file,
                  const Console& console);

/// Number of cells of the mesh that the table [mesh] yields. Throws UserError, Interrupted. Collective.
std::int64_t cells(MPI_Comm comm, const scene::Mesh& mesh);

/// Throws UserError if the two coarsest of a ladder's sizes give meshes with equally many cells, as with a
/// .geo that sets its own mesh density (by Transfinite curves, for example). Collective.
void require_sizes_take_effect(MPI_Comm comm, const scene::Scene& scene, const std::vector<double>& sizes);
/// Throws UserError if half of the scene's element size, the size itself and twice the size all give meshes
/// with equally many cells, as with a .geo that sets its own mesh density. Collective.
void require_size_takes_effect(MPI_Comm comm, const scene::Scene& scene);

} // namespace signorini::accuracy
