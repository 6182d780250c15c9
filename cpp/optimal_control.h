#pragma once
#include "base/progress.h"
#include "scene/scene.h"
#include <filesystem>
#include <mpi.h>

namespace signorini {

/// Solves the scene's control problem into a folder and returns the exit status; with `resume` from the folder's
/// checkpoint, where it has one. Collective. Throws UserError, SolverFailure, WriteFailure, Interrupted.
int optimize_scene(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out, bool resume,
                   const Console& console);

} // namespace signorini
