// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace signorini {

/// A point as text for messages: its first `dim` coordinates, m, with six significant digits.
std::string point_text(const double* x, int dim = 3);

/// The names as "a, b, c".
std::string list(const std::vector<std::string>& names);

/// Edit distance (Levenshtein).
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The valid name with the least edit distance from `found`; empty if none is close.
std::string nearest(std::string_view found, const std::vector<std::string>& valid);

/// The nearest valid name as a question that follows what was found, ` (did you mean "x"?)`; empty if none is
/// close.
std::string suggestion(std::string_view found, const std::vector<std::string>& valid);

} // namespace signorini
