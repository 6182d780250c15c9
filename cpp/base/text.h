// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace signorini {

/// Formats a point for messages: its first `dim` coordinates, in the unit of `x`, with six significant
/// digits.
std::string point_text(const double* x, int dim = 3);

/// Formats a memory size with its unit, kB, MB or GB.
std::string bytes_text(double bytes);

/// Joins names as "a, b, c".
std::string list(const std::vector<std::string>& names);

/// Levenshtein distance: the least number of inserted, deleted or replaced bytes that turns `a` into `b`.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// Valid name with the least edit distance from `found`, for spelling suggestions; empty if none is similar.
std::string nearest(std::string_view found, const std::vector<std::string>& valid);

/// Suggestion for a message, to follow the misspelt name `found`: ` (did you mean "x"?)`; empty if no valid
/// name is similar.
std::string suggestion(std::string_view found, const std::vector<std::string>& valid);

} // namespace signorini
