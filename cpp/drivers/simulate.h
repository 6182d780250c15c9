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
  bool replace = false;                   ///< whether files that a search left in the folder may be removed
  bool measure = false;                   ///< whether to write the files of the scene's measurements
  int seed = 1;                           ///< seed of the noise in these files; 0: no noise
  std::optional<io::Accuracy> accuracy{}; ///< errors to be written with the results
  bool keep_mesh = false;                 ///< whether to store the mesh in the folder
  bool complete_only = false; ///< whether to discard an interrupted motion, so that an earlier result stays
};

/// Runs the verb simulate: computes the scene's motion and writes the results into the folder `out`. Returns
/// the exit status. Throws UserError, SolverFailure, WriteFailure, Interrupted. Collective.
int simulate_scene(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
                   const SimulateOptions& options, const Console& console);

} // namespace signorini::drivers
