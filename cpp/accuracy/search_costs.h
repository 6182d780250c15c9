// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include <mpi.h>
#include <string>
#include <vector>

/// Cost of a search's accuracy, apart from that of its mesh and its steps.
namespace signorini::accuracy {

/// A search of a scene's optimum to one tolerance.
struct SearchCost {
  double tolerance = 0; ///< optimizer.tolerance
  double objective = 0; ///< J where the search ends
  int iterations = 0;   ///< number on the scene's mesh, as of sweeps
  int forward_sweeps = 0, adjoint_sweeps = 0;
  double seconds = 0; ///< time of the search with its coarse meshes, without mesh and set-up
  std::string stop_reason{};
};

/// Throws UserError, in the words of the option `--search-tolerances`, unless the scene has a control and an
/// objective and no parameters to fit, and the tolerances are from 0 to 1.
void require_searches(const scene::Scene& scene, const std::vector<double>& tolerances);

/// Searches the optimum of the scene with this optimizer.tolerance, as the verb optimize does. Collective.
/// Throws UserError, SolverFailure, Interrupted.
SearchCost search_to(MPI_Comm comm, const scene::Scene& scene, double tolerance);

/// J of each search above the least of them, relative to that one's modulus; NaN where that is zero.
std::vector<double> above_least(const std::vector<SearchCost>& searches);

/// search.csv: a row for each search.
std::string csv(const std::vector<SearchCost>& searches);

/// The table of the searches for the console, without the last line's end.
std::string table(const std::vector<SearchCost>& searches);

/// Names the cheapest search that leaves at most a tenth of `error`, or states that none does. `error`:
/// estimated error of J by the size and the step, relative.
std::string sentence(const std::vector<SearchCost>& searches, double error);

} // namespace signorini::accuracy
