// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/rungs.h"
#include "base/progress.h"
#include <functional>
#include <mpi.h>
#include <optional>

namespace signorini::accuracy {

struct Options {
  Choice choice;
  std::vector<std::string> quantities; ///< names; empty: all that the scene has but the gradient
  std::optional<double> budget;        ///< s
  bool dry_run = false;                ///< price the ladder and stop
};

/// Runs the ladder in the order of cost and leaves study.csv, study.json and a file for each rung in `out`.
/// Rungs that are already there are not run again. With a budget it stops before a rung that would not end
/// within it. Returns the exit status: 130 if interrupted, with the results so far kept. Collective. Throws
/// UserError, SolverFailure.
int run_study(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
              const Options& options, const Console& console);

/// Proposes a size and step for a relative error below `tolerance` of the one quantity that the options name,
/// else of J, from an estimate of the scene's own (Trials), runs them, and reports whether by their own
/// estimate the tolerance is met; repeats from there if not, a few times and within the options' budget, else
/// of ten minutes. Returns the exit status: 1 if it is not met. Collective. Throws UserError, SolverFailure,
/// Interrupted.
int suggest(MPI_Comm comm, const scene::Scene& scene, double tolerance, const Options& options,
            const Console& console);

/// What find_size_and_step() found: a rung, and the estimated parts of its error, relative.
struct BestRun {
  Rung rung;
  double space = 0, time = 0;
  double seconds = 0; ///< of the rung alone
  double further =
      0; ///< expected of all that the tolerance would take or, where it is met, half the error, s
  std::string warning; ///< why it is not verified though its error is small, in words
  [[nodiscard]] double error() const { return space + time; }
  [[nodiscard]] bool meets(double tolerance) const { return error() <= tolerance && warning.empty(); }
};

/// Searches a size and a step as suggest() does, for the one quantity that the options name of the motion
/// that simulate makes, and shows each that is better than all before to `better`, first of all a coarse one
/// of which no error is known (1); without a budget until the tolerance is met or nothing changes any more.
/// Returns the best. Collective. Throws UserError, SolverFailure, Interrupted.
BestRun find_size_and_step(MPI_Comm comm, const scene::Scene& scene, double tolerance, const Options& options,
                           const Console& console, const std::function<void(const BestRun&)>& better);

} // namespace signorini::accuracy
