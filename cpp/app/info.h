// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "problem/problem.h"

namespace signorini::app {

/// Runs the verb info: prints the sizes of the problem and, for each effect that a scene can contain (such as
/// viscosity or contact), whether this scene contains it and which matrices, memory and work per step it
/// adds. To estimate the run time, computes `timed_steps` forward steps, and as many adjoint steps if the
/// scene has an objective. Throws UserError, SolverFailure. Collective.
void print_info(problem::Problem& problem, int timed_steps, const Console& console);

} // namespace signorini::app
