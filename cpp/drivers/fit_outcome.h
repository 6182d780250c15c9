// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/error.h"
#include "drivers/motion_writer.h"
#include "io/fit_tables.h"
#include "problem/parameter_problem.h"
#include <optional>

namespace signorini::drivers {

/// Collects the results of a fit that ended at the iterate `last`. `simulated`: simulated values of all data,
/// at this iterate.
io::Fit outcome(const problem::ParameterProblem& problem, const optimize::GaussNewtonIterate& last,
                const std::vector<double>& simulated);

/// Sentence that names a combination of unknowns that the data do not determine. `direction`: coefficients of
/// the combination (optimize::Identified::unidentified).
std::string unidentified(const std::vector<scene::Unknown>& unknowns, const std::vector<double>& direction);

/// Warns if the residuals of a fit are larger than noise of the given deviations explains.
std::optional<Warning> misfit_warning(const io::Fit& fit);

/// Lines of a table of a fit's results for the console, with sentences on unknowns that the data do not
/// determine.
std::vector<std::string> outcome_lines(const io::Fit& fit);

/// Simulated counterparts of measurements.
struct Simulated {
  std::vector<double> values;                 ///< values of the fitted measurements, in the order of the data
  std::vector<io::ComparedQuantity> compared; ///< quantities that are compared, but not fitted
};

/// Simulates the motion under `load` once more, writes its files through `recorder` and returns the simulated
/// measurements. Ignores requests to stop. Throws UserError, SolverFailure, WriteFailure. Collective.
Simulated simulate_measured(const problem::Problem& problem, const problem::ParameterProblem& fit,
                            const step::ForceAtStep& load, MotionWriter& recorder);

} // namespace signorini::drivers
