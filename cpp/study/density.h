#pragma once
#include "scene/scene.h"
#include <mpi.h>
#include <vector>

namespace signorini::study {

/// Whether element sizes change the mesh of a scene, which those of a .geo that sets its own density do not (Transfinite
/// curves, say). Both are collective and throw UserError where the sizes are needed and of no effect: for a ladder of rungs
/// of these sizes, by its two coarsest, and for sizes next to the scene's own.
void require_answer_to(MPI_Comm comm, const scene::Scene& scene, const std::vector<double>& sizes);
void require_answer(MPI_Comm comm, const scene::Scene& scene);

} // namespace signorini::study
