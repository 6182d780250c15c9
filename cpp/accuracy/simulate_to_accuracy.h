// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/refinement_loop.h"
#include "drivers/simulate.h"

namespace signorini::accuracy {

/// Runs the verb simulate with --accuracy: refines size and step until the relative error of the requested
/// quantity meets the request. Writes each motion that is better than all before into `out`. Prints a
/// sentence on the requested and the estimated error, and returns the exit status. Throws UserError,
/// SolverFailure, WriteFailure, Interrupted. Collective.
int simulate_to_accuracy(MPI_Comm comm, scene::Scene scene, const std::filesystem::path& out,
                         const AccuracyAsked& asked, drivers::SimulateOptions how, const Console& console);

} // namespace signorini::accuracy
