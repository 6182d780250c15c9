// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/refinement_loop.h"
#include "drivers/simulate.h"

namespace signorini::accuracy {

/// Runs the verb simulate with --accuracy: searches for a size and a step that meet the relative error of the
/// requested quantity. Writes each motion that is better than those before into `out`. Ends with a sentence
/// about the requested and the reached error, and returns the exit status. Collective. Throws UserError,
/// SolverFailure, WriteFailure, Interrupted.
int simulate_to_accuracy(MPI_Comm comm, scene::Scene scene, const std::filesystem::path& out,
                         const AccuracyAsked& asked, drivers::SimulateOptions how, const Console& console);

} // namespace signorini::accuracy
