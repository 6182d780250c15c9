// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "app/optimizer_log.h"
#include "optimize/options.h"
#include "optimize/report.h"
#include <filesystem>
#include <mpi.h>

namespace signorini {

/// The verb optimize: solves the scene's control problem, writes the results into the folder `out` and
/// returns the exit status; with `resume` it continues from the folder's checkpoint, if there is one.
/// Collective. Throws UserError, SolverFailure, WriteFailure, Interrupted.
int optimize_scene(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out, bool resume,
                   const Console& console);

/// Throws UserError unless the scene has a control and an objective and the results go into another folder
/// than that of a desired run. Collective.
void require_control_problem(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out);

/// How a search has ended.
struct FoundOptimum {
  optimize::Stop stop;
  double first_norm; ///< of the gradient, at the first guess
  std::vector<io::CoarseLevel> levels{};
  std::optional<io::Accuracy> accuracy{};
};

/// Writes the results of a search, whose control is the problem's current one, puts them in place and tells
/// of them. `scene`: as it is written, of which this is the run. Collective. Throws UserError, SolverFailure,
/// WriteFailure.
void write_optimum(io::OutputFolder& folder, const Problem& problem, const scene::Scene& scene,
                   ControlProblem& control_problem, OptimizerLog& record, FoundOptimum found,
                   const Console& console);

/// What the scene asks of a search for these controls. Collective. Throws UserError if optimizer.memory is
/// too little.
optimize::Options search_options(const control::ControlSpace& controls, const scene::Optimizer& scene);

} // namespace signorini
