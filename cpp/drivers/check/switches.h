// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/reduced_problem.h"

namespace signorini::drivers {

using ContactHistory = control::ReducedProblem::ContactHistory;

/// Differences between the active sets of two motions.
struct Switches {
  int steps = 0, candidates = 0; ///< steps with a difference; differing candidates, summed over the steps
};
/// Counts the differences between the active sets of two motions, including the active sets of projected
/// predictors.
Switches switches(const ContactHistory& a, const ContactHistory& b);

/// Counts the candidates at which steps of a motion, or their predictors, have a kink, summed over the steps.
int kinks(const ContactHistory& contact);

} // namespace signorini::drivers
