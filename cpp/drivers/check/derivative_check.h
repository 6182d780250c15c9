// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "control/reduced_problem.h"
#include <string>
#include <vector>

namespace signorini::drivers {

/// Row of check's table.
struct CheckRow {
  std::string name, measured, allowed;
  bool holds;
};

/// Row that passes if `value` is at most `limit`.
CheckRow below(const std::string& name, double value, double limit);

using ContactHistory = std::vector<contact::ContactLinearisation>;

/// Changes of candidates between active and open from one motion to another, those of projected predictors
/// included.
struct Switches {
  int steps = 0, candidates = 0;
};
Switches switches(const ContactHistory& a, const ContactHistory& b);

/// Compares the derivatives of J at u with differences of J, prints the range in which they are valid, and
/// adds rows to the table. `solver_tolerance` is the relative error of a step's solve. Returns advice if
/// exact derivatives are useless because J has other slopes over larger changes of the control; else an empty
/// text. Collective. Throws SolverFailure, Interrupted.
std::string check_derivatives(control::ReducedProblem& problem, const control::Control& u,
                              double solver_tolerance, const Console& console, std::vector<CheckRow>& rows);

} // namespace signorini::drivers
