// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "drivers/check/derivative_check.h"
#include "problem/parameter_problem.h"

namespace signorini::drivers {

/// Checks the derivatives of a fit's J at the start values: the gradients of two methods against each other,
/// and the derivative by each unknown against differences. Adds rows to the table, and prints which unknowns
/// the data do not determine. `solver_tolerance`: relative error of the linear solves in a step. Throws
/// SolverFailure, Interrupted. Collective.
void check_fit(problem::ParameterProblem& problem, double solver_tolerance, const Console& console,
               std::vector<CheckRow>& rows);

/// Checks the gradient of J by control and unknowns together: the Taylor remainder at the first guess, along
/// the direction of steepest descent. Adds a row to the table. Collective.
void check_joint(control::ReducedProblem& problem, double solver_tolerance, std::vector<CheckRow>& rows);

} // namespace signorini::drivers
