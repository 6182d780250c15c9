// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include <mpi.h>
#include <string>
#include <vector>

/// Cost and error of searches, as a function of optimizer.tolerance on a given mesh and time grid.
namespace signorini::accuracy {

/// Result of a search for a scene's optimum with one value of optimizer.tolerance.
struct SearchCost {
  double tolerance = 0;                       ///< optimizer.tolerance
  double objective = 0;                       ///< J at the end of the search
  int iterations = 0;                         ///< number of iterations on the scene's mesh
  int forward_sweeps = 0, adjoint_sweeps = 0; ///< numbers of sweeps on the scene's mesh
  double seconds = 0; ///< time of the search, including coarse meshes, excluding meshing and set-up
  std::string stop_reason{};
};

/// Throws UserError, naming the option `--search-tolerances`, unless the scene has a control, an objective
/// and no unknowns, and the tolerances are from 0 to 1.
void require_searches(const scene::Scene& scene, const std::vector<double>& tolerances);

/// Searches the optimum of the scene with this optimizer.tolerance, as the verb optimize does. Collective.
/// Throws UserError, SolverFailure, Interrupted.
SearchCost search_to(MPI_Comm comm, const scene::Scene& scene, double tolerance);

/// Returns (J − J_least) / |J_least| for each search, where J_least is the least J of all searches; NaN if
/// J_least is zero.
std::vector<double> above_least(const std::vector<SearchCost>& searches);

/// Text of search.csv: a row for each search.
std::string csv(const std::vector<SearchCost>& searches);

/// Table of the searches for the console, without a line feed at the end.
std::string table(const std::vector<SearchCost>& searches);

/// Sentence that names the cheapest search whose remaining error of J is at most a tenth of `error`, or
/// states that there is no such search. `error`: estimated relative error of J due to mesh and time steps.
std::string sentence(const std::vector<SearchCost>& searches, double error);

} // namespace signorini::accuracy
