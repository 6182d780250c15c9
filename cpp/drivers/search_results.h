// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "drivers/search_log.h"
#include "io/manifest.h"

namespace signorini::drivers {

/// How a search has ended.
struct SearchEnd {
  optimize::Stop stop;
  double first_norm = std::numeric_limits<double>::quiet_NaN(); ///< of the gradient, at the first guess
  std::optional<optimize::GaussNewtonIterate> fitted{};         ///< of parameters alone
  std::string failure{};                                        ///< of the last trial that failed
  std::vector<io::CoarseLevel> levels{};
  std::optional<io::Accuracy> accuracy{};
};

/// Writes the results of a search, whose point is the reduced problem's current one or the fitted one, puts
/// them in place and reports them. Collective. Throws UserError, SolverFailure, WriteFailure.
void write_results(io::OutputFolder& folder, SearchLog& log, SearchEnd end, const Console& console);

} // namespace signorini::drivers
