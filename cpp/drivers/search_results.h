// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "drivers/search_log.h"
#include "io/manifest.h"

namespace signorini::drivers {

/// Reason for the end of a search, with its figures.
struct SearchEnd {
  optimize::Stop stop;
  double first_norm = std::numeric_limits<double>::quiet_NaN(); ///< gradient norm at the first guess
  std::optional<optimize::GaussNewtonIterate> fitted{};         ///< last iterate for parameters alone
  std::string failure{};                                        ///< message of the last trial that failed
  std::vector<io::CoarseLevel> levels{};
  std::optional<io::Accuracy> accuracy{};
};

/// Writes the results of a search, at its current variables or at the fitted values, moves them into the
/// output folder and prints them. Collective. Throws UserError, SolverFailure, WriteFailure.
void write_results(io::OutputFolder& folder, SearchLog& log, SearchEnd end, const Console& console);

} // namespace signorini::drivers
