// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/channel_filter.h"
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace signorini::diagnostics {

std::vector<double> channel_filtered(std::span<const double> samples, double interval, double channel_class) {
  // SAE J211-1, appendix C: the corner frequency of one pass, so that both together have -3 dB at 1.65 times
  // the class.
  constexpr double corner = 2.0775;
  const double rate = std::tan(std::numbers::pi * channel_class * corner * interval), square = rate * rate,
               whole = 1 + std::numbers::sqrt2 * rate + square, a = square / whole,
               b1 = -2 * (square - 1) / whole, b2 = (-1 + std::numbers::sqrt2 * rate - square) / whole;
  std::vector<double> series(samples.begin(), samples.end());
  constexpr double settled = 10; // periods of the class after which the filter has forgotten a sample
  const double last = series.empty() ? 0 : series.back();
  series.resize(samples.size() + static_cast<std::size_t>(settled / (channel_class * interval)), last);
  double before = 0;
  for (int pass = 0; pass < 2; ++pass) {
    double x1 = before, x2 = x1, y1 = x1, y2 = x1;
    for (double& x : series) {
      const double y = a * (x + 2 * x1 + x2) + b1 * y1 + b2 * y2;
      x2 = std::exchange(x1, x);
      y2 = std::exchange(y1, y);
      x = y;
    }
    std::ranges::reverse(series);
    before = last;
  }
  series.resize(samples.size());
  return series;
}

} // namespace signorini::diagnostics
