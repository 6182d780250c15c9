// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/text.h"
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <span>

namespace signorini {

std::string point_text(const double* x, int dim) {
  return fmt::format("({:.6g})", fmt::join(std::span(x, static_cast<std::size_t>(dim)), ", "));
}

} // namespace signorini
