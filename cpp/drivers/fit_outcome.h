// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "drivers/motion_writer.h"
#include "io/fit_tables.h"
#include "problem/parameter_problem.h"
#include <optional>

namespace signorini::drivers {

/// The outcome of a fit that ended at an iterate; `simulated` are the values there.
io::Fit outcome(const problem::ParameterProblem& problem, const optimize::GaussNewtonIterate& last,
                const std::vector<double>& simulated);

/// A sentence on a direction along which nothing changes (optimize::Identified::unidentified).
std::string unidentified(const std::vector<scene::Unknown>& unknowns, const std::vector<double>& direction);

/// Warns if the residuals are more than noise.
std::optional<Warning> misfit_warning(const io::Fit& fit);

/// The outcome as a table for the console, and what the data do not tell.
std::vector<std::string> outcome_lines(const io::Fit& fit);

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
