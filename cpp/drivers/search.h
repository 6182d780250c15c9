// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "control/control_space.h"
#include "optimize/options.h"
#include <filesystem>
#include <mpi.h>

namespace signorini::drivers {

/// Runs the verb optimize: searches a control, parameters, or both, writes the results into the folder `out`
/// and returns the exit status. With `resume` it continues from the folder's checkpoint, if there is one.
/// Collective. Throws UserError, SolverFailure, WriteFailure, Interrupted.
int search_scene(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out, bool resume,
                 const Console& console);

/// Throws UserError unless the scene has a control and an objective and the results go into another folder
/// than that of a desired run. Collective.
void require_control_problem(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out);

/// Options of a search for these controls, as set by the scene. Collective. Throws UserError if
/// optimizer.memory is too little.
optimize::Options search_options(const control::ControlSpace& controls, const scene::Optimizer& scene);

} // namespace signorini::drivers
