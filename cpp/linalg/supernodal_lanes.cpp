// SPDX-License-Identifier: GPL-3.0-or-later
// Substitutions for several right-hand sides at once.
#include "linalg/lane_kernels.h"
#include "linalg/supernodal.h"
#include "linalg/supernode.h"
#include <algorithm>
#include <omp.h>
#include <ranges>

namespace signorini {

namespace {

/// Number of rows (forward) or columns (backward) of a panel that a thread takes at a time: multiples of the
/// kernels' tiles.
constexpr std::ptrdiff_t lane_rows = 64, lane_columns = 8;

/// Block of a supernode, for the kernels.
FactorBlock part(const Supernode& s, std::ptrdiff_t row, std::ptrdiff_t rows, std::ptrdiff_t column,
                 std::ptrdiff_t columns) {
  return {s.values + column * s.height + row, rows, columns, s.height};
}

/// First value of an unknown.
double* at(const LaneGroup& group, std::ptrdiff_t unknown) { return group.values + unknown * group.lanes; }

/// Adds the rows of `from` to the rows `row` of a group.
void add_rows(const int* row, std::ptrdiff_t rows, const double* from, const LaneGroup& to) {
  for (std::ptrdiff_t i = 0; i < rows; ++i)
    for (std::ptrdiff_t lane = 0; lane < to.lanes; ++lane)
      at(to, row[i])[lane] += from[i * to.lanes + lane];
}
void copy_rows(const LaneGroup& from, const int* row, std::ptrdiff_t rows, double* to) {
  for (std::ptrdiff_t i = 0; i < rows; ++i)
    std::copy_n(at(from, row[i]), from.lanes, to + i * from.lanes);
}

} // namespace

double* TriangularSolves::outside_of(const Subtree& subtree, std::span<const LaneGroup> groups,
                                     std::size_t group) {
  std::size_t before = 0;
  for (std::size_t g = 0; g < group; ++g)
    before += static_cast<std::size_t>(groups[g].lanes);
  return outside_lanes_.data() + before * outside_.size() +
         subtree.outside * static_cast<std::size_t>(groups[group].lanes);
}

void TriangularSolves::forward(const Subtree& subtree, std::span<const LaneGroup> groups) {
  const std::ptrdiff_t reached = supernode(L_, subtree.root).below();
  for (std::size_t g = 0; g < groups.size(); ++g)
    std::fill_n(outside_of(subtree, groups, g), reached * groups[g].lanes, 0.0);
  for (int s = subtree.first; s <= subtree.root; ++s) {
    const Supernode one = supernode(L_, s);
    const std::ptrdiff_t inside = inside_[s];
    const int* const place = place_.data() + (one.rows_below - static_cast<const int*>(L_.s));
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const std::ptrdiff_t lanes = groups[g].lanes;
      for (std::ptrdiff_t c = 0; c < one.width; c += panel_width) {
        const std::ptrdiff_t width = std::min(panel_width, one.width - c), end = c + width;
        double* const own = at(groups[g], one.first + c);
        solve_lanes(part(one, c, width, c, width), lanes, own);
        subtract_lanes(part(one, end, one.width - end, c, width), lanes, own, nullptr, own + width * lanes);
        subtract_lanes(part(one, one.width, inside, c, width), lanes, own, one.rows_below, groups[g].values);
        subtract_lanes(part(one, one.width + inside, one.below() - inside, c, width), lanes, own,
                       place + inside, outside_of(subtree, groups, g));
      }
    }
  }
}

void TriangularSolves::backward(const Subtree& subtree, std::span<const LaneGroup> groups) {
  const Supernode root = supernode(L_, subtree.root);
  for (std::size_t g = 0; g < groups.size(); ++g)
    copy_rows(groups[g], root.rows_below, root.below(), outside_of(subtree, groups, g));
  for (int s = subtree.root; s >= subtree.first; --s) {
    const Supernode one = supernode(L_, s);
    const std::ptrdiff_t inside = inside_[s];
    const int* const place = place_.data() + (one.rows_below - static_cast<const int*>(L_.s));
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const std::ptrdiff_t lanes = groups[g].lanes;
      for (std::ptrdiff_t c = (one.width - 1) / panel_width * panel_width; c >= 0; c -= panel_width) {
        const std::ptrdiff_t width = std::min(panel_width, one.width - c), end = c + width;
        double* const own = at(groups[g], one.first + c);
        subtract_lanes_transposed(part(one, end, one.width - end, c, width), lanes, own + width * lanes,
                                  nullptr, own);
        subtract_lanes_transposed(part(one, one.width, inside, c, width), lanes, groups[g].values,
                                  one.rows_below, own);
        subtract_lanes_transposed(part(one, one.width + inside, one.below() - inside, c, width), lanes,
                                  outside_of(subtree, groups, g), place + inside, own);
        solve_lanes_transposed(part(one, c, width, c, width), lanes, own);
      }
    }
  }
}

void TriangularSolves::forward_trunk(const Trunk& trunk, std::span<const LaneGroup> groups) {
  for (int s = trunk.first; s <= trunk.last; ++s) {
    const Supernode one = supernode(L_, s);
    for (const LaneGroup& group : groups)
      for (std::ptrdiff_t c = 0; c < one.width; c += panel_width) {
        const std::ptrdiff_t width = std::min(panel_width, one.width - c), end = c + width;
        double* const own = at(group, one.first + c);
#pragma omp single
        solve_lanes(part(one, c, width, c, width), group.lanes, own);
#pragma omp for schedule(static)
        for (std::ptrdiff_t row = end; row < one.height; row += lane_rows) {
          const std::ptrdiff_t stop = std::min(row + lane_rows, one.height),
                               own_stop = std::max(row, std::min(stop, one.width));
          subtract_lanes(part(one, row, own_stop - row, c, width), group.lanes, own, nullptr,
                         at(group, one.first + row));
          if (stop > own_stop)
            subtract_lanes(part(one, own_stop, stop - own_stop, c, width), group.lanes, own,
                           one.rows_below + (own_stop - one.width), group.values);
        }
      }
  }
}

void TriangularSolves::backward_trunk(const Trunk& trunk, std::span<const LaneGroup> groups) {
  for (int s = trunk.last; s >= trunk.first; --s) {
    const Supernode one = supernode(L_, s);
    for (const LaneGroup& group : groups)
      for (std::ptrdiff_t c = (one.width - 1) / panel_width * panel_width; c >= 0; c -= panel_width) {
        const std::ptrdiff_t width = std::min(panel_width, one.width - c), end = c + width;
#pragma omp for schedule(static)
        for (std::ptrdiff_t j = c; j < end; j += lane_columns) {
          const std::ptrdiff_t columns = std::min(lane_columns, end - j);
          subtract_lanes_transposed(part(one, end, one.width - end, j, columns), group.lanes,
                                    at(group, one.first + end), nullptr, at(group, one.first + j));
          subtract_lanes_transposed(part(one, one.width, one.below(), j, columns), group.lanes, group.values,
                                    one.rows_below, at(group, one.first + j));
        }
#pragma omp single
        solve_lanes_transposed(part(one, c, width, c, width), group.lanes, at(group, one.first + c));
      }
  }
}

void TriangularSolves::forward(std::span<const LaneGroup> groups) {
  std::size_t lanes = 0;
  for (const LaneGroup& group : groups)
    lanes += static_cast<std::size_t>(group.lanes);
  outside_lanes_.resize(std::max(outside_lanes_.size(), lanes * outside_.size()));
#pragma omp parallel num_threads(static_cast<int>(work_.size()))
  {
#pragma omp for schedule(dynamic, 1)
    for (std::size_t i = 0; i < subtrees_.size(); ++i)
      forward(subtrees_[i], groups);
#pragma omp single
    for (const Subtree& subtree : subtrees_) {
      const Supernode root = supernode(L_, subtree.root);
      for (std::size_t g = 0; g < groups.size(); ++g)
        add_rows(root.rows_below, root.below(), outside_of(subtree, groups, g), groups[g]);
    }
    for (const Trunk& trunk : trunk_)
      forward_trunk(trunk, groups);
  }
}

void TriangularSolves::backward(std::span<const LaneGroup> groups) {
#pragma omp parallel num_threads(static_cast<int>(work_.size()))
  {
    for (const Trunk& trunk : trunk_ | std::views::reverse)
      backward_trunk(trunk, groups);
#pragma omp for schedule(dynamic, 1)
    for (std::size_t i = 0; i < subtrees_.size(); ++i)
      backward(subtrees_[i], groups);
  }
}

} // namespace signorini
