// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/study.h"
#include "base/progress.h"
#include <filesystem>
#include <string>
#include <vector>

namespace signorini::app {

struct SceneFile;

/// A request of the command line.
struct Request {
  std::string verb; ///< simulate, optimize, check, study or info
  std::filesystem::path scene;
  std::filesystem::path out; ///< empty: results/<scene name>
  std::vector<std::string> overrides;
  bool resume = false;        ///< continue optimize from its checkpoint
  bool replace = false;       ///< simulate may remove a search's results from its folder
  bool measure = false;       ///< simulate writes the files of the scene's measurements
  int seed = 1;               ///< seed of their noise; 0: no noise
  int timed_steps = 0;        ///< number of steps that info makes and times
  std::optional<int> threads; ///< threads of each rank; absent: use_threads() chooses
  accuracy::Options study;
  std::optional<double> suggest;  ///< tolerance for which study proposes size and step
  std::optional<double> accuracy; ///< relative error that simulate and optimize have to meet
};

/// Runs the request on MPI_COMM_WORLD and returns the exit status. Collective. Throws UserError,
/// SolverFailure, Interrupted.
int run(const Request& request, const Console& console);

/// Runs the request with a scene that was read before.
int run(const Request& request, const SceneFile& file, const Console& console);

} // namespace signorini::app
