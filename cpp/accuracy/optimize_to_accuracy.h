// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "scene/scene.h"
#include <filesystem>
#include <mpi.h>
#include <optional>

namespace signorini::accuracy {

/// What is asked of an answer.
struct AccuracyAsked {
  double error;                 ///< relative, of the quantity
  std::optional<double> budget; ///< s
};

/// The verb optimize with --accuracy: the optimum, J to a relative error. Alternates searches and refinements
/// of mesh and steps, from about four times the scene's size and step on (with mesh.size = "auto" from ten
/// elements across the body, with sizes that vary), each search from the result of the last, until the
/// estimate of the error says that it is met, or the budget is spent. The answer of every round is written
/// into `out` in place of the last one, whole. Ends with a sentence that says what was asked, what is
/// estimated, what it has cost, and what half the error would cost. Returns the exit status: 1 if it is not
/// met, 130 if interrupted. Collective. Throws UserError, SolverFailure, WriteFailure, and Interrupted before
/// there is an answer.
int optimize_to_accuracy(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
                         const AccuracyAsked& asked, const Console& console);

} // namespace signorini::accuracy
