// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "control/control_space.h"
#include "optimize/options.h"
#include <filesystem>
#include <mpi.h>

namespace signorini::drivers {

/// The verb optimize: searches what the scene leaves open – a control, parameters, or both –, writes the
/// results into the folder `out` and returns the exit status; with `resume` it continues from the folder's
/// checkpoint, if there is one. Collective. Throws UserError, SolverFailure, WriteFailure, Interrupted.
int search_scene(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out, bool resume,
                 const Console& console);

/// Throws UserError unless the scene has a control and an objective and the results go into another folder
/// than that of a desired run. Collective.
void require_control_problem(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out);

/// The options of a search for these controls, as the scene sets them. Collective. Throws UserError if
/// optimizer.memory is too little.
optimize::Options search_options(const control::ControlSpace& controls, const scene::Optimizer& scene);

} // namespace signorini::drivers
