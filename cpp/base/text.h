// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <string>

namespace signorini {

/// A point as text for messages: its first `dim` coordinates, m, with six significant digits.
std::string point_text(const double* x, int dim = 3);

} // namespace signorini
