// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "scene/scene.h"
#include <filesystem>
#include <mpi.h>

namespace signorini {

/// optimize for a scene with unknowns: fits them to its measurements and writes the results; the motion
/// stored is that of the fitted scene. Returns the exit status. Collective. Throws UserError, SolverFailure,
/// Interrupted.
int fit_scene(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out, bool resume,
              const Console& console);

} // namespace signorini
