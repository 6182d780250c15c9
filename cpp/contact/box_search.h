// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/box.h"
#include <cstddef>
#include <vector>

namespace signorini::contact {

/// Returns for each of the `boxes` the numbers of the `others` that it overlaps, ascending. Not collective.
[[nodiscard]] std::vector<std::vector<std::size_t>> overlaps(const std::vector<Box>& boxes,
                                                             const std::vector<Box>& others);

} // namespace signorini::contact
