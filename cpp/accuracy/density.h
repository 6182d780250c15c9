// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include <cstdint>
#include <mpi.h>
#include <vector>

namespace signorini::accuracy {

/// Cells of a .geo meshed as the scene says. Collective. Throws UserError, Interrupted.
std::int64_t cells(MPI_Comm comm, const scene::Mesh& mesh);

/// Throw UserError if the sizes are needed but do not change the mesh of a scene, as with a .geo that sets
/// its own density (Transfinite curves, say): require_answer_to() by the two coarsest of a ladder's sizes,
/// require_answer() by sizes next to the scene's own. Collective.
void require_answer_to(MPI_Comm comm, const scene::Scene& scene, const std::vector<double>& sizes);
void require_answer(MPI_Comm comm, const scene::Scene& scene);

} // namespace signorini::accuracy
