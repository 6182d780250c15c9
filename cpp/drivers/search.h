// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "control/control_space.h"
#include "optimize/options.h"
#include <filesystem>
#include <mpi.h>

namespace signorini::drivers {

/// Runs the verb optimize: searches for a control, parameters or both, and writes the results into the folder
/// `out`. If `resume`, continues from the folder's checkpoint, if it has one. Returns the exit status. Throws
/// UserError, SolverFailure, WriteFailure, Interrupted. Collective.
int search_scene(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out, bool resume,
                 const Console& console);

/// Throws UserError unless the scene has a control and an objective, and `out` is not the folder of the run
/// whose motion is desired. Collective.
void require_control_problem(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out);

/// Options of a search in the space `controls`, from the scene's table [optimizer]. Throws UserError if
/// optimizer.memory is too small. Collective.
optimize::Options search_options(const control::ControlSpace& controls, const scene::Optimizer& scene);

} // namespace signorini::drivers
