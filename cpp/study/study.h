#pragma once
#include "base/progress.h"
#include "study/ladder.h"
#include <mpi.h>
#include <optional>

namespace signorini::study {

struct Options {
  Choice choice;
  std::vector<std::string> quantities; ///< names; empty: all that the scene has but the gradient
  std::optional<double> budget;        ///< s
  bool dry_run = false;                ///< price the ladder and stop
};

/// Runs the ladder in ascending cost and leaves study.csv, study.json and a file for each rung in `out`. Rungs that are there
/// already are not run again. With a budget it stops before a rung that would not end within it. Returns the exit status: 130 if
/// interrupted, with what has run kept. Collective. Throws UserError, SolverFailure.
int run_study(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out, const Options& options, const Console& console);

/// Proposes a size and step for an error of J below `tolerance`, relative, from the estimate of one run, runs them, and says whether
/// by their own estimate the tolerance is met; again from there if not, a few times and as long as a budget (s) lasts. Returns the exit status: 1 if it is not met.
/// Collective. Throws UserError, SolverFailure.
int suggest(MPI_Comm comm, const scene::Scene& scene, double tolerance, std::optional<double> budget, const Console& console);

} // namespace signorini::study
