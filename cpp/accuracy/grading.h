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
/// with ten across the body. With an objective the error is that of J, at the control of `check`
/// (drivers::evaluation_point()), by its adjoint estimate, else that of the stress in the energy of all
/// steps, by what is recovered from it (fem::StressRecovery). Two motions of degree 1 on coarse meshes tell.
/// Curved boundaries keep elements as small as those of the scene's own mesh, but for a factor, because of
/// the polygon that they make of it. Collective. Throws UserError, SolverFailure, Interrupted.
void write_graded(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& file,
                  const Console& console);

/// Cells of a .geo meshed as the scene says. Collective. Throws UserError, Interrupted.
std::int64_t cells(MPI_Comm comm, const scene::Mesh& mesh);

/// Throw UserError if the sizes are needed but do not change the mesh of a scene, as with a .geo that sets
/// its own density (Transfinite curves, say): require_answer_to() by the two coarsest of a ladder's sizes,
/// require_answer() by sizes next to the scene's own. Collective.
void require_answer_to(MPI_Comm comm, const scene::Scene& scene, const std::vector<double>& sizes);
void require_answer(MPI_Comm comm, const scene::Scene& scene);

} // namespace signorini::accuracy
