// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/side_by_side.h"
#include "base/machine.h"
#include "linalg/lane_kernels.h"
#include <algorithm>
#include <cstdint>

namespace signorini {

namespace {

/// Number of unknowns that are copied for one right-hand side after another, so that their lanes stay in the
/// cache.
constexpr std::size_t piece = 128;

/// Calls visit(values of the group, its lanes, first right-hand side, number of right-hand sides, first
/// unknown, end) for pieces of the unknowns, on all threads.
template <class Visit>
void for_pieces(std::span<const LaneGroup> groups, std::size_t count, std::size_t n, Visit&& visit) {
  const auto pieces = static_cast<std::ptrdiff_t>((n + piece - 1) / piece);
#pragma omp parallel for schedule(static) num_threads(threads())
  for (std::ptrdiff_t p = 0; p < pieces; ++p) {
    const std::size_t first = static_cast<std::size_t>(p) * piece, end = std::min(first + piece, n);
    std::size_t before = 0;
    for (const LaneGroup& group : groups) {
      const auto lanes = static_cast<std::size_t>(group.lanes);
      visit(group.values, lanes, before, std::min(lanes, count - before), first, end);
      before += lanes;
    }
  }
}

} // namespace

void SideBySide::resize(std::size_t n, std::size_t count) {
  if (n == n_ && count == count_)
    return;
  n_ = n;
  count_ = count;
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
  for (LaneGroup& group : groups_) {
    group.values = values;
    values += n * static_cast<std::size_t>(group.lanes);
  }
  for (std::size_t i = count; i < lanes; ++i)
    for (std::size_t unknown = 0; unknown < n; ++unknown)
      column(i)[unknown] = 0;
}

void SideBySide::gather(std::span<const double* const> from, const int* order) {
  for_pieces(groups_, count_, n_,
             [&](double* values, std::size_t lanes, std::size_t before, std::size_t here, std::size_t first,
                 std::size_t end) {
               for (std::size_t k = 0; k < here; ++k) {
                 const double* const one = from[before + k];
                 for (std::size_t i = first; i < end; ++i)
                   values[i * lanes + k] = one[order ? static_cast<std::size_t>(order[i]) : i];
               }
             });
}

void SideBySide::scatter(const int* order, std::span<double* const> to) const {
  for_pieces(groups_, count_, n_,
             [&](const double* values, std::size_t lanes, std::size_t before, std::size_t here,
                 std::size_t first, std::size_t end) {
               for (std::size_t k = 0; k < here; ++k) {
                 double* const one = to[before + k];
                 for (std::size_t i = first; i < end; ++i)
                   one[order ? static_cast<std::size_t>(order[i]) : i] = values[i * lanes + k];
               }
             });
}

void SideBySide::copy(const SideBySide& other) {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const auto size = static_cast<std::ptrdiff_t>(n_) * groups_[g].lanes;
    const double* const from = other.groups_[g].values;
    double* const to = groups_[g].values;
#pragma omp parallel for schedule(static) num_threads(threads())
    for (std::ptrdiff_t i = 0; i < size; ++i)
      to[i] = from[i];
  }
}

SideBySide::Column SideBySide::column(std::size_t i) const {
  std::size_t group = 0;
  while (i >= static_cast<std::size_t>(groups_[group].lanes))
    i -= static_cast<std::size_t>(groups_[group++].lanes);
  return {groups_[group].values + i, static_cast<std::size_t>(groups_[group].lanes)};
}

void SideBySide::copy_column(const SideBySide& other, std::size_t i, std::size_t to) {
  const Column from = other.column(i), here = column(to);
  for (std::size_t unknown = 0; unknown < n_; ++unknown)
    here[unknown] = from[unknown];
}

} // namespace signorini
