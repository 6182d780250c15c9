// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "scene/scene.h"
#include <cstdint>
#include <filesystem>
#include <mpi.h>
#include <vector>

namespace signorini::accuracy {

/// Writes `file`, a .geo with the scene's body whose element sizes vary: small where the error comes from. At
/// mesh.scale = 1 it has about as many elements as the scene's own mesh or, with mesh.size = "auto", as one
/// with ten across the body. With an objective the error is the adjoint estimate of J's error at the control
/// of `check` (drivers::evaluation_point()). Else it is the error of the stress, in the energy norm over all
/// steps, by stress recovery (fem::StressRecovery). It comes from two motions of degree 1 on coarse meshes.
/// At curved boundaries elements are larger than those of the scene's own mesh by at most a factor, since
/// they form a polygon there. Collective. Throws UserError, SolverFailure, Interrupted.
void write_graded(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& file,
                  const Console& console);

/// Number of cells of a .geo meshed with the scene's settings. Collective. Throws UserError, Interrupted.
std::int64_t cells(MPI_Comm comm, const scene::Mesh& mesh);

/// Throw UserError if the sizes are needed but do not change the mesh of a scene, as with a .geo that sets
/// its own density (Transfinite curves, say). require_answer_to() compares the two coarsest of a ladder's
/// sizes, require_answer() sizes next to the scene's own. Collective.
void require_answer_to(MPI_Comm comm, const scene::Scene& scene, const std::vector<double>& sizes);
void require_answer(MPI_Comm comm, const scene::Scene& scene);

} // namespace signorini::accuracy
