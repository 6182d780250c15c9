// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/solver/contact_step_solver.h"
#include "base/timers.h"

namespace signorini::contact {

namespace {
long &solvers = count("VI solvers"), &solved = count("VIs solved");
}

ContactStepSolver::ContactStepSolver() { ++solvers; }

void ContactStepSolver::count_solved() { ++solved; }

} // namespace signorini::contact
