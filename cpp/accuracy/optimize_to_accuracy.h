// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/refinement_loop.h"

namespace signorini::accuracy {

/// Runs the verb optimize with --accuracy: searches for the optimum until the relative error of J meets the
/// request. Alternates searches and refinements of mesh and steps (refine_to_accuracy()); each search starts
/// from the result of the previous one. Starts at about four times the scene's size and step; with mesh.size
/// = "auto", at ten elements across the body. After each run that is better than all before, writes complete
/// results into `out`. Returns the exit status. Throws UserError, SolverFailure, WriteFailure; Interrupted
/// before the first result. Collective.
int optimize_to_accuracy(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
                         const AccuracyAsked& asked, const Console& console);

} // namespace signorini::accuracy
