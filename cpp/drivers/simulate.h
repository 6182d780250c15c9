// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "io/manifest.h"
#include <filesystem>
#include <mpi.h>
#include <optional>

namespace signorini::drivers {

/// Options of the verb simulate.
struct SimulateOptions {
  bool replace = false;                   ///< may remove files that a search left in its folder
  bool measure = false;                   ///< writes the files of the scene's measurements
  int seed = 1;                           ///< seed of the noise in these files; 0: none
  std::optional<io::Accuracy> accuracy{}; ///< written with the results
  bool keep_mesh = false;                 ///< stores the mesh in the folder, for its scene
  bool whole = false; ///< does not write an interrupted motion, which would replace a whole one
};

/// Runs the verb simulate: computes the scene's motion, writes the results into the folder `out` and returns
/// the exit status. Collective. Throws UserError, SolverFailure, WriteFailure, Interrupted.
int simulate_scene(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
                   const SimulateOptions& options, const Console& console);

} // namespace signorini::drivers
