// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/refinement_loop.h"

namespace signorini::accuracy {

/// Runs the verb optimize with --accuracy: searches for the optimum until the relative error of J meets the
/// request. Alternates searches and refinements of mesh and steps (refine_to_accuracy()); each search starts
/// from the result of the previous one. The first run has about four times the scene's step and element size;
/// with mesh.size = "auto" it has ten elements across the body, and with a .msh it has the mesh of this file.
/// After each run that is better than all before, writes complete results into `out`. Returns the exit
/// status. Throws UserError, SolverFailure, WriteFailure. Throws Interrupted if it is interrupted before the
/// first result. Collective.
int optimize_to_accuracy(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
                         const AccuracyAsked& asked, const Console& console);

} // namespace signorini::accuracy
