#pragma once
#include <string>

namespace signorini {

/// A point as messages show it: its first `dim` coordinates, m, with six digits.
std::string point_text(const double* x, int dim = 3);

} // namespace signorini
