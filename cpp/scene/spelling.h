// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace signorini::scene {

/// The valid name with the least edit distance from `found`, for suggestions; empty if none is close.
std::string nearest(std::string_view found, const std::vector<std::string>& valid);

/// A key such as material[0].young or material.0.young without the numbers of tables.
std::string without_numbers(std::string_view key);

/// The names as "a, b, c".
std::string list(const std::vector<std::string>& names);

} // namespace signorini::scene
