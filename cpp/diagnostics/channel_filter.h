// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <span>
#include <vector>

namespace signorini::diagnostics {

/// Filters samples with the equal distance `interval` (s) by SAE J211's digital filter of a channel frequency
/// class such as 60, 180, 600 or 1000. It is a Butterworth filter of second order, forwards and then
/// backwards, so that phases stay. The channel is taken to be zero before the first sample, as before an
/// impact, and constant after the last.
std::vector<double> channel_filtered(std::span<const double> samples, double interval, double channel_class);

} // namespace signorini::diagnostics
