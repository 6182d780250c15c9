// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "drivers/check/derivative_check.h"
#include "problem/parameter_problem.h"

namespace signorini::drivers {

/// Compares the derivatives of a fit's J at the start with each other and, by each unknown, with differences
/// of J. Adds rows to the table, and prints which unknowns the data do not determine. `solver_tolerance` is
/// the relative error of a step's solve. Collective. Throws SolverFailure, Interrupted.
void check_fit(problem::ParameterProblem& problem, double solver_tolerance, const Console& console,
               std::vector<CheckRow>& rows);

/// Checks the Taylor order of J by a control and the unknowns together, at the first guess along the steepest
/// descent; adds a row to the table.
void check_joint(control::ReducedProblem& problem, double solver_tolerance, std::vector<CheckRow>& rows);

} // namespace signorini::drivers
