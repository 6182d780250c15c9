// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/side_by_side.h"
#include "linalg/lane_kernels.h"
#include <algorithm>
#include <cstdint>

namespace signorini {

void SideBySide::resize(std::size_t n, std::size_t count) {
  groups_.clear();
  std::size_t lanes = 0;
  while (lanes < count) {
    groups_.push_back(
        {nullptr, count - lanes > static_cast<std::size_t>(narrow_lanes) ? wide_lanes : narrow_lanes});
    lanes += static_cast<std::size_t>(groups_.back().lanes);
  }
  constexpr std::size_t bytes = 64, line = bytes / sizeof(double); // of a cache line
  values_.resize(std::max(values_.size(), n * lanes + line));
  double* values = values_.data();
  while (reinterpret_cast<std::uintptr_t>(values) % bytes != 0)
    ++values;
  for (TriangularSolves::LaneGroup& group : groups_) {
    group.values = values;
    values += n * static_cast<std::size_t>(group.lanes);
  }
  for (std::size_t i = count; i < lanes; ++i)
    for (std::size_t unknown = 0; unknown < n; ++unknown)
      column(i)[unknown] = 0;
}

SideBySide::Column SideBySide::column(std::size_t i) const {
  std::size_t group = 0;
  while (i >= static_cast<std::size_t>(groups_[group].lanes))
    i -= static_cast<std::size_t>(groups_[group++].lanes);
  return {groups_[group].values + i, static_cast<std::size_t>(groups_[group].lanes)};
}

} // namespace signorini
