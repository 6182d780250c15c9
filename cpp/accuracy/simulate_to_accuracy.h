// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/refinement_loop.h"
#include "drivers/simulate.h"

namespace signorini::accuracy {

/// The verb simulate with --accuracy: searches a size and a step that meet the relative error of the asked
/// quantity, and writes the motion of each that is better than those before into `out`. Ends with a sentence
/// of what was asked and reached, and returns the exit status. Collective. Throws UserError, SolverFailure,
/// WriteFailure, Interrupted.
int simulate_to_accuracy(MPI_Comm comm, scene::Scene scene, const std::filesystem::path& out,
                         const AccuracyAsked& asked, drivers::SimulateOptions how, const Console& console);

} // namespace signorini::accuracy
