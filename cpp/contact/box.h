// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace signorini::contact {

/// Box parallel to the axes, given by two opposite corners, m. In the plane the third components are zero.
struct Box {
  std::array<double, 3> low{}, high{};

  /// Returns an empty box, which include() can extend.
  [[nodiscard]] static Box empty(int dim) {
    Box box;
    std::fill_n(box.low.begin(), dim, std::numeric_limits<double>::infinity());
    std::fill_n(box.high.begin(), dim, -std::numeric_limits<double>::infinity());
    return box;
  }
  [[nodiscard]] double longest_side() const {
    return std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  }
  [[nodiscard]] double diagonal() const {
    return std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
  }
  /// Extends the box so that it contains a point or another box.
  void include(const std::array<double, 3>& x) { // called for every node at every stored time
    for (std::size_t c = 0; c < 3; ++c) {
      low[c] = std::min(low[c], x[c]);
      high[c] = std::max(high[c], x[c]);
    }
  }
  void include(const Box& other) {
    include(other.low);
    include(other.high);
  }
};

} // namespace signorini::contact
