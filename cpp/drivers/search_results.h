// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "drivers/search_log.h"
#include "io/manifest.h"

namespace signorini::drivers {

/// End of a search: its reason, and data of the search for the results.
struct SearchEnd {
  optimize::Stop stop;
  double first_norm = std::numeric_limits<double>::quiet_NaN(); ///< gradient norm at the first guess
  std::optional<optimize::GaussNewtonIterate> fitted{};         ///< last iterate of a fit without a control
  std::string failure{};                                        ///< message of the last trial that failed
  std::vector<io::CoarseLevel> levels{};                        ///< searches on coarse meshes
  std::optional<io::Accuracy> accuracy{};                       ///< errors of J, with --accuracy
};

/// Writes and prints the results of a search, at `end.fitted` if given (a fit without a control), otherwise
/// at the current variables of the reduced problem. Moves the files into the output folder. Throws UserError,
/// SolverFailure, WriteFailure. Collective.
void write_results(io::OutputFolder& folder, SearchLog& log, SearchEnd end, const Console& console);

} // namespace signorini::drivers
