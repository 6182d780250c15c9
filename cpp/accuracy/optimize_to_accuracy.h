// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/refinement_loop.h"

namespace signorini::accuracy {

/// Runs the verb optimize with --accuracy: finds the optimum with J to a relative error. Alternates searches
/// and refinements of mesh and steps (refine_to_accuracy()), each search from the result of the last. Starts
/// at about four times the scene's size and step or, with mesh.size = "auto", at ten elements across the body
/// with sizes that vary. The best answer so far is written into `out` after each run, whole. Collective.
/// Throws UserError, SolverFailure, WriteFailure, and Interrupted before there is an answer.
int optimize_to_accuracy(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
                         const AccuracyAsked& asked, const Console& console);

} // namespace signorini::accuracy
