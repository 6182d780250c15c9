// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "app/motion_writer.h"
#include "app/parameter_problem.h"
#include "io/fit_tables.h"

namespace signorini {

/// What a motion gives of what was measured.
struct Simulated {
  std::vector<double> values;
  std::vector<io::ComparedFigure> compared;
};

/// Makes the motion once more, for its files and for this. A request to stop is ignored. Collective. Throws
/// UserError, SolverFailure, WriteFailure.
Simulated simulate_measured(const Problem& problem, const ParameterProblem& fit,
                            const forward::ForceAtStep& load, MotionWriter& recorder);

} // namespace signorini
