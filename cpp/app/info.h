// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "problem/problem.h"

namespace signorini::app {

/// Runs the verb info: prints sizes, effects that are on or off, and the matrices, other memory and work per
/// step that each adds. Makes no steps except `timed_steps` forward ones, and as many adjoint ones of a scene
/// with an objective, to estimate the time of the whole. Collective. Throws UserError, SolverFailure.
void print_info(problem::Problem& problem, int timed_steps, const Console& console);

} // namespace signorini::app
