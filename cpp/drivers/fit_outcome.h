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

/// Sentence on a combination of unknowns that the data do not determine (optimize::Identified::unidentified).
std::string unidentified(const std::vector<scene::Unknown>& unknowns, const std::vector<double>& direction);

/// Warns if the residuals are more than noise.
std::optional<Warning> misfit_warning(const io::Fit& fit);

/// Outcome as a table for the console, with sentences on the unknowns that the data do not determine.
std::vector<std::string> outcome_lines(const io::Fit& fit);

/// Values and figures of a motion to compare with the measured ones.
struct Simulated {
  std::vector<double> values;
  std::vector<io::ComparedFigure> compared;
};

/// Repeats the motion, for its files and for the values to compare. A request to stop is ignored. Collective.
/// Throws UserError, SolverFailure, WriteFailure.
Simulated simulate_measured(const problem::Problem& problem, const problem::ParameterProblem& fit,
                            const step::ForceAtStep& load, MotionWriter& recorder);

} // namespace signorini::drivers
