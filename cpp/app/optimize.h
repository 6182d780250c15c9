#pragma once
#include "base/progress.h"
#include "control/control.h"
#include "optimize/options.h"
#include "scene/scene.h"
#include <filesystem>
#include <mpi.h>

namespace signorini {

/// The verb optimize: solves the scene's control problem, writes the results into the folder `out` and
/// returns the exit status; with `resume` it continues from the folder's checkpoint, if there is one.
/// Collective. Throws UserError, SolverFailure, WriteFailure, Interrupted.
int optimize_scene(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out, bool resume,
                   const Console& console);

/// What the scene asks of a search for these controls. Collective. Throws UserError if optimizer.memory is
/// too little.
optimize::Options search_options(const control::ControlSpace& controls, const scene::Optimizer& scene);

} // namespace signorini
