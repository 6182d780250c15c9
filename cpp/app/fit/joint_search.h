// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "scene/scene.h"
#include <filesystem>
#include <mpi.h>

namespace signorini {

/// optimize for a scene with a control problem and unknowns: seeks both together, by L-BFGS, and writes the
/// results. Returns the exit status. Collective. Throws UserError, SolverFailure, WriteFailure, Interrupted.
int search_jointly(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out, bool resume,
                   const Console& console);

} // namespace signorini
