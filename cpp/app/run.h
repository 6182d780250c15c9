// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/study.h"
#include "base/progress.h"
#include "batch/batch.h"
#include <filesystem>
#include <string>
#include <vector>

namespace signorini::app {

struct SceneFile;

/// A run that the command line requests.
struct Request {
  std::string verb;                   ///< simulate, optimize, check, study, batch or info
  std::filesystem::path scene;        ///< scene file
  std::filesystem::path out;          ///< output folder; empty: results/<scene name>
  std::vector<std::string> overrides; ///< arguments `key.path=value` of --set
  bool resume = false;                ///< whether optimize continues from its checkpoint
  bool replace = false;       ///< whether simulate may remove a search's results from its output folder
  bool measure = false;       ///< whether simulate writes the files of the scene's measurements
  int seed = 1;               ///< seed of the noise in these files; 0: no noise
  int timed_steps = 0;        ///< number of steps that info computes and times
  std::optional<int> threads; ///< threads of each rank; absent: use_threads() chooses
  accuracy::Options study;
  batch::Options batch;
  std::optional<double> suggest;  ///< relative error for which study proposes size and step
  std::optional<double> accuracy; ///< relative error that simulate and optimize must meet
};

/// Reads the scene of a request, runs the request on MPI_COMM_WORLD and returns the exit status. Throws
/// UserError, SolverFailure, Interrupted. Collective.
int run(const Request& request, const Console& console);

/// Runs a request with the scene in `file`, which has been read already, and returns the exit status. Throws
/// UserError, SolverFailure, Interrupted. Collective.
int run(const Request& request, const SceneFile& file, const Console& console);

} // namespace signorini::app
