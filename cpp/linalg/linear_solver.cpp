// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/linear_solver.h"
#include "base/timers.h"

namespace signorini {

namespace {
long& solves = count("solves with D");
}

void LinearSolver::count_solves(long made) { solves += made; }

} // namespace signorini
