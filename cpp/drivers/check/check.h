// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "problem/problem.h"

namespace signorini::drivers {

/// Runs the verb check: checks the derivatives and the discrete invariants of a scene, prints a table, and
/// returns whether all rows pass. If a scene has contact but the body never touches an obstacle, the check
/// fails. Throws UserError, SolverFailure, Interrupted. Collective.
bool check_scene(problem::Problem& problem, const Console& console);

} // namespace signorini::drivers
