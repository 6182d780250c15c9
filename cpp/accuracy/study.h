// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/rungs.h"
#include "base/progress.h"
#include <mpi.h>
#include <optional>

namespace signorini::accuracy {

struct Options {
  Choice choice;
  std::vector<std::string> quantities;   ///< names; empty: all that the scene has but the gradient
  std::vector<double> search_tolerances; ///< optimizer.tolerance of each search after the ladder
  std::optional<double> budget;          ///< s
  bool dry_run = false;                  ///< price the ladder and stop
};

/// Runs the ladder in the order of cost and leaves study.csv, study.json and a file for each rung in `out`.
/// Rungs that are already there are not run again. With search_tolerances it then searches for the optimum of
/// the scene to each, and writes cost and remaining error to search.csv. With a budget it stops before a rung
/// that would not end within it. Returns the exit status: 130 if interrupted, with the results so far kept.
/// Collective. Throws UserError, SolverFailure.
int run_study(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
              const Options& options, const Console& console);

/// Proposes a size and step for a relative error below `tolerance`, of the one quantity that the options
/// name, else of J. Starts from an estimate for the scene's own rung (study_trials()), runs the proposal, and
/// reports whether its own estimate meets the tolerance. If not, repeats from there, a few times and within
/// the options' budget, else ten minutes. Returns the exit status: 1 if the tolerance is not met. Collective.
/// Throws UserError, SolverFailure, Interrupted.
int suggest(MPI_Comm comm, const scene::Scene& scene, double tolerance, const Options& options,
            const Console& console);

} // namespace signorini::accuracy
