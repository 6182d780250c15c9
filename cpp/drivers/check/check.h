// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "problem/problem.h"

namespace signorini::drivers {

/// Runs the verb check: checks the derivatives and the discrete invariants of a scene, prints a table, and
/// returns whether all rows pass. A contact scene whose body never touches the obstacle fails, since contact
/// remains unchecked. Collective. Throws UserError, SolverFailure, Interrupted.
bool check_scene(problem::Problem& problem, const Console& console);

} // namespace signorini::drivers
