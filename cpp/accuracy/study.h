// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/rungs.h"
#include "base/progress.h"
#include <mpi.h>
#include <optional>

namespace signorini::accuracy {

/// Options of the verb study.
struct Options {
  Choice choice;
  std::vector<std::string> quantities;   ///< names of the quantities to compare; empty: default of chosen()
  std::vector<double> search_tolerances; ///< optimizer.tolerance of each search after the ladder
  std::optional<double> budget;          ///< time limit, s
  bool dry_run = false;                  ///< whether only to predict the cost of the ladder
};

/// Runs the verb study: runs the rungs of a ladder in ascending order of predicted cost, and writes
/// study.csv, study.json and a file for each rung into `out`. Rungs with results in `out` are not repeated.
/// Afterwards searches for the scene's optimum with each of search_tolerances, and writes costs and remaining
/// errors to search.csv. Does not start a rung or search that would exceed the budget. Returns the exit
/// status: 130 if interrupted, with the results so far written. Throws UserError, SolverFailure. Collective.
int run_study(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
              const Options& options, const Console& console);

/// Runs the verb study with --suggest: proposes size and step for which the relative error of one quantity is
/// below `tolerance`. options.quantities names this quantity, by default J. Estimates the error on the
/// scene's own rung (study_trials()), derives a proposal, runs it, and reports whether its estimated error
/// meets the tolerance. If not, repeats this from the proposal, within the budget (default: ten minutes).
/// Returns the exit status: 1 if the tolerance is not met. Throws UserError, SolverFailure, Interrupted.
/// Collective.
int suggest(MPI_Comm comm, const scene::Scene& scene, double tolerance, const Options& options,
            const Console& console);

} // namespace signorini::accuracy
