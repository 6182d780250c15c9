// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cmath>
#include <utility>
#include <vector>

namespace signorini {

/// Least-squares slope of log y over log x for points (x, y): the observed order of convergence of y. Not
/// finite for fewer than two points.
inline double log_log_slope(const std::vector<std::pair<double, double>>& points) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const auto& [abscissa, ordinate] : points) {
    const double a = std::log(abscissa), b = std::log(ordinate);
    n += 1, x += a, y += b, xx += a * a, xy += a * b;
  }
  return (n * xy - x * y) / (n * xx - x * x);
}

} // namespace signorini
