// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "problem/problem.h"

namespace signorini::app {

/// The verb info: prints sizes, which effects are on or off, and what each adds in matrices, other memory and
/// work per step. Makes no steps except `timed_steps` forward ones, and as many adjoint ones of a scene with
/// an objective, from which it estimates the time of the whole. Collective. Throws UserError, SolverFailure.
void print_info(problem::Problem& problem, int timed_steps, const Console& console);

} // namespace signorini::app
