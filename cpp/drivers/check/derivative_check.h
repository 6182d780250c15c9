// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "control/reduced_problem.h"
#include <string>
#include <vector>

namespace signorini::drivers {

/// Row of the table that the verb check prints.
struct CheckRow {
  std::string name, measured, allowed; ///< what is checked, its value and its limit, as text
  bool holds;                          ///< whether the check passes
};

/// Makes a row that passes if `value` is at most `limit`.
CheckRow below(const std::string& name, double value, double limit);

/// Compares the derivatives of J at u with differences of J, prints the range in which the derivatives are
/// valid, and adds rows to the table. `solver_tolerance`: relative error of the linear solves in a step.
/// Returns advice if the derivatives are exact but useless, since J has other slopes over larger
/// changes of the control; else an empty text. Throws SolverFailure, Interrupted. Collective.
std::string check_derivatives(control::ReducedProblem& problem, const control::Control& u,
                              double solver_tolerance, const Console& console, std::vector<CheckRow>& rows);

} // namespace signorini::drivers
