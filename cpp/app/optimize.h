#pragma once
#include "base/progress.h"
#include "scene/scene.h"
#include <filesystem>
#include <mpi.h>

namespace signorini {

/// The verb optimize: solves the scene's control problem, writes the results into the folder `out` and
/// returns the exit status; with `resume` it continues from the folder's checkpoint, if there is one.
/// Collective. Throws UserError, SolverFailure, WriteFailure, Interrupted.
int optimize_scene(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out, bool resume,
                   const Console& console);

} // namespace signorini
