// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "drivers/motion_writer.h"
#include "io/fit_tables.h"
#include "problem/parameter_problem.h"

namespace signorini::drivers {

/// What a motion gives of what was measured.
struct Simulated {
  std::vector<double> values;
  std::vector<io::ComparedFigure> compared;
};

/// Makes the motion once more, for its files and for this. A request to stop is ignored. Collective. Throws
/// UserError, SolverFailure, WriteFailure.
Simulated simulate_measured(const problem::Problem& problem, const problem::ParameterProblem& fit,
                            const step::ForceAtStep& load, MotionWriter& recorder);

} // namespace signorini::drivers
