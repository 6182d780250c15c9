// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <string>

namespace signorini::forward {

/// A reason to doubt the results of a run.
struct Warning {
  std::string name;    ///< of the kind of warning
  std::string message; ///< with value and place
  double value, limit; ///< the value, and the limit above which there is a warning
};

} // namespace signorini::forward
