// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/supernodal.h"
#include "linalg/supernode.h"
#include <algorithm>
#include <numeric>
#include <omp.h>
#include <queue>
#include <ranges>
#include <utility>

// Debian builds for baseline x86-64; the loops below gain from a second version for wider vector registers.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define SIGNORINI_WIDE __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define SIGNORINI_WIDE
#endif

namespace signorini {

namespace {

/// Number of supernodes by which the prefetch is ahead: memory latency is the time of one or two solves.
constexpr std::ptrdiff_t lookahead = 4;
constexpr std::ptrdiff_t cache_line = 64 / sizeof(double);
/// Number of entries of a supernode that are prefetched: the machine itself continues a stream once begun,
/// and several large supernodes would drive each other out of the cache before their turn.
constexpr std::ptrdiff_t prefetched = 1024;

/// Number of rows (forward) or columns (backward) of a panel that a thread takes at a time.
constexpr std::ptrdiff_t rows_at_once = 128, columns_at_once = 8;
/// Number of entries above which a supernode is divided among threads. Threads synchronise twice per panel,
/// which takes about as long as reading a thousand entries.
constexpr std::ptrdiff_t worth_dividing = 16'384;
/// Approximate number of subtrees of equal work: large enough for an even distribution among threads, small
/// enough to leave little work above the subtrees.
constexpr double subtrees_wanted = 48;

void prefetch(const cholmod_factor& L, std::ptrdiff_t s) {
  if (s < 0 || s >= count(L))
    return;
  const Supernode next = supernode(L, s);
  for (std::ptrdiff_t i = 0; i < std::min(next.width * next.height, prefetched); i += cache_line)
    __builtin_prefetch(next.values + i);
}

/// Rectangular block of a supernode, stored column by column with the distance `stride`.
struct Block {
  const double* values; ///< first entry
  std::ptrdiff_t rows, columns, stride;
};

Block block(const Supernode& s, std::ptrdiff_t row, std::ptrdiff_t rows, std::ptrdiff_t column,
            std::ptrdiff_t columns) {
  return {s.values + column * s.height + row, rows, columns, s.height};
}

/// below −= B own, for a block B and the vectors `own` (columns) and `below` (rows).
SIGNORINI_WIDE void subtract_product(const Block& B, const double* __restrict own, double* __restrict below) {
  const double* __restrict column = B.values;
  std::ptrdiff_t j = 0;
  for (; j + 4 <= B.columns; j += 4, column += 4 * B.stride) { // four columns for each pass over `below`
    const double *c1 = column + B.stride, *c2 = c1 + B.stride, *c3 = c2 + B.stride;
#pragma omp simd
    for (std::ptrdiff_t i = 0; i < B.rows; ++i)
      below[i] -= own[j] * column[i] + own[j + 1] * c1[i] + own[j + 2] * c2[i] + own[j + 3] * c3[i];
  }
  for (; j < B.columns; ++j, column += B.stride)
#pragma omp simd
    for (std::ptrdiff_t i = 0; i < B.rows; ++i)
      below[i] -= own[j] * column[i];
}

/// own −= Bᵀ below, for a block B and the vectors `own` (columns) and `below` (rows).
SIGNORINI_WIDE void subtract_transposed_product(const Block& B, const double* __restrict below,
                                                double* __restrict own) {
  const double* __restrict column = B.values;
  std::ptrdiff_t j = 0;
  for (; j + 4 <= B.columns; j += 4, column += 4 * B.stride) {
    const double *c1 = column + B.stride, *c2 = c1 + B.stride, *c3 = c2 + B.stride;
    double d0 = 0, d1 = 0, d2 = 0, d3 = 0;
#pragma omp simd reduction(+ : d0, d1, d2, d3)
    for (std::ptrdiff_t i = 0; i < B.rows; ++i) {
      d0 += column[i] * below[i];
      d1 += c1[i] * below[i];
      d2 += c2[i] * below[i];
      d3 += c3[i] * below[i];
    }
    own[j] -= d0;
    own[j + 1] -= d1;
    own[j + 2] -= d2;
    own[j + 3] -= d3;
  }
  for (; j < B.columns; ++j, column += B.stride) {
    double d = 0;
#pragma omp simd reduction(+ : d)
    for (std::ptrdiff_t i = 0; i < B.rows; ++i)
      d += column[i] * below[i];
    own[j] -= d;
  }
}

/// own ← T⁻¹ own, where T is the triangle of the panel of `width` columns that starts at column `begin`.
void solve_triangle(const Supernode& s, std::ptrdiff_t begin, std::ptrdiff_t width, double* own) {
  for (std::ptrdiff_t j = 0; j < width; ++j) {
    const double* column = s.values + (begin + j) * s.height + begin;
    own[j] /= column[j];
    for (std::ptrdiff_t i = j + 1; i < width; ++i)
      own[i] -= column[i] * own[j];
  }
}

/// own ← T⁻ᵀ own, where T is the triangle of the panel of `width` columns that starts at column `begin`.
void solve_transposed_triangle(const Supernode& s, std::ptrdiff_t begin, std::ptrdiff_t width, double* own) {
  for (std::ptrdiff_t j = width; j-- > 0;) {
    const double* column = s.values + (begin + j) * s.height + begin;
    for (std::ptrdiff_t i = j + 1; i < width; ++i)
      own[j] -= column[i] * own[i];
    own[j] /= column[j];
  }
}

/// Solves with the diagonal block of a supernode and sets below = −B own for the rows B below it.
void forward(const Supernode& s, double* own, double* below) {
  std::fill_n(below, s.below(), 0.0);
  for (std::ptrdiff_t c = 0; c < s.width; c += panel_width) {
    const std::ptrdiff_t width = std::min(panel_width, s.width - c), end = c + width;
    solve_triangle(s, c, width, own + c);
    subtract_product(block(s, end, s.width - end, c, width), own + c, own + end);
    subtract_product(block(s, s.width, s.below(), c, width), own + c, below);
  }
}

/// own ← (diagonal block)⁻ᵀ (own − Bᵀ below), where B are the rows below the diagonal block.
void backward(const Supernode& s, double* own, const double* below) {
  for (std::ptrdiff_t c = (s.width - 1) / panel_width * panel_width; c >= 0; c -= panel_width) {
    const std::ptrdiff_t width = std::min(panel_width, s.width - c), end = c + width;
    subtract_transposed_product(block(s, end, s.width - end, c, width), own + end, own + c);
    subtract_transposed_product(block(s, s.width, s.below(), c, width), below, own + c);
    solve_transposed_triangle(s, c, width, own + c);
  }
}

/// Adds the `count` values of `from` to the entries `rows` of z.
void add_at(const int* rows, std::ptrdiff_t count, const double* from, std::span<double> z) {
  for (std::ptrdiff_t i = 0; i < count; ++i)
    z[rows[i]] += from[i];
}

/// Copies the entries `rows` of z to `to`.
void take_at(const int* rows, std::ptrdiff_t count, std::span<const double> z, double* to) {
  for (std::ptrdiff_t i = 0; i < count; ++i)
    to[i] = z[rows[i]];
}

/// Parent of each supernode in the elimination tree: the supernode with the first row below it; −1: root.
std::vector<int> parents(const cholmod_factor& L) {
  const auto* super = static_cast<const int*>(L.super);
  std::vector<int> of_column(L.n), parent(L.nsuper, -1);
  for (int s = 0; s < count(L); ++s)
    std::fill(of_column.begin() + super[s], of_column.begin() + super[s + 1], s);
  for (int s = 0; s < count(L); ++s)
    if (const Supernode one = supernode(L, s); one.below() > 0)
      parent[s] = of_column[*one.rows_below];
  return parent;
}

} // namespace

TriangularSolves::TriangularSolves(const cholmod_factor& L)
    : L_(L), inside_(L.nsuper), place_(L.ssize), shared_(L.maxesize),
      work_(static_cast<std::size_t>(omp_get_max_threads()), std::vector<double>(L.maxesize)) {
  plan_subtrees();
  number_outside_rows();
}

void TriangularSolves::plan_subtrees() {
  const std::vector<int> parent = parents(L_);
  const std::size_t n = parent.size();
  std::vector<double> work(n);    // entries of L in each subtree
  std::vector<int> first(n);      // first supernode of each subtree
  std::vector<int> members(n, 1); // supernodes of each subtree
  std::vector<std::vector<int>> children(n);
  using Heavy = std::pair<double, int>;
  std::priority_queue<Heavy> cut;
  double total = 0;
  std::iota(first.begin(), first.end(), 0);
  for (std::size_t s = 0; s < n; ++s) { // children come before their parents
    const Supernode one = supernode(L_, static_cast<std::ptrdiff_t>(s));
    work[s] += static_cast<double>(one.width * one.height);
    total += static_cast<double>(one.width * one.height);
    if (parent[s] < 0) {
      cut.emplace(work[s], static_cast<int>(s));
      continue;
    }
    const auto p = static_cast<std::size_t>(parent[s]);
    work[p] += work[s];
    members[p] += members[s];
    first[p] = std::min(first[p], first[s]);
    children[p].push_back(static_cast<int>(s));
  }
  std::vector<bool> in_trunk(n, false);
  while (!cut.empty()) {
    const auto [entries, root] = cut.top();
    const auto s = static_cast<std::size_t>(root);
    cut.pop();
    const bool contiguous = root - first[s] + 1 == members[s]; // as in a postordered tree
    if (entries <= total / subtrees_wanted && contiguous) {
      subtrees_.push_back({first[s], root, 0});
      continue;
    }
    in_trunk[s] = true;
    for (int child : children[s])
      cut.emplace(work[child], child);
  }
  plan_trunk(in_trunk);
}

void TriangularSolves::plan_trunk(const std::vector<bool>& in_trunk) {
  for (int s = 0; s < count(L_); ++s) {
    if (!in_trunk[s])
      continue;
    const Supernode one = supernode(L_, s);
    const bool divided = one.width * one.height >= worth_dividing;
    if (!divided && !trunk_.empty() && !trunk_.back().divided && trunk_.back().last == s - 1)
      trunk_.back().last = s;
    else
      trunk_.push_back({s, s, divided});
  }
}

void TriangularSolves::number_outside_rows() {
  const int* const rows = static_cast<const int*>(L_.s);
  std::vector<int> place(L_.n);
  std::size_t size = 0;
  for (Subtree& subtree : subtrees_) {
    const Supernode root = supernode(L_, subtree.root);
    subtree.outside = size;
    size += static_cast<std::size_t>(root.below());
    for (int i = 0; i < static_cast<int>(root.below()); ++i)
      place[root.rows_below[i]] = i;
    const auto end = static_cast<int>(root.first + root.width);
    for (int s = subtree.first; s <= subtree.root; ++s) {
      const Supernode one = supernode(L_, s);
      const int* const below = one.rows_below; // ascending
      const std::ptrdiff_t inside = std::lower_bound(below, below + one.below(), end) - below;
      inside_[s] = static_cast<int>(inside);
      for (std::ptrdiff_t i = inside; i < one.below(); ++i)
        place_[below - rows + i] = place[below[i]];
    }
  }
  outside_.resize(size);
}

void TriangularSolves::forward(const Subtree& subtree, std::span<double> z, std::span<double> work) {
  const std::ptrdiff_t reached = supernode(L_, subtree.root).below();
  const std::span<double> outside =
      std::span(outside_).subspan(subtree.outside, static_cast<std::size_t>(reached));
  std::ranges::fill(outside, 0.0);
  for (int s = subtree.first; s <= subtree.root; ++s) {
    prefetch(L_, s + lookahead);
    const Supernode one = supernode(L_, s);
    signorini::forward(one, z.data() + one.first, work.data());
    const std::ptrdiff_t inside = inside_[s];
    add_at(one.rows_below, inside, work.data(), z);
    add_at(place_.data() + (one.rows_below - static_cast<const int*>(L_.s)) + inside, one.below() - inside,
           work.data() + inside, outside);
  }
}

void TriangularSolves::backward(const Subtree& subtree, std::span<double> z, std::span<double> work) {
  const Supernode root = supernode(L_, subtree.root);
  const std::span<double> outside =
      std::span(outside_).subspan(subtree.outside, static_cast<std::size_t>(root.below()));
  take_at(root.rows_below, root.below(), z, outside.data());
  for (int s = subtree.root; s >= subtree.first; --s) {
    prefetch(L_, s - lookahead);
    const Supernode one = supernode(L_, s);
    const std::ptrdiff_t inside = inside_[s];
    take_at(one.rows_below, inside, z, work.data());
    take_at(place_.data() + (one.rows_below - static_cast<const int*>(L_.s)) + inside, one.below() - inside,
            outside, work.data() + inside);
    signorini::backward(one, z.data() + one.first, work.data());
  }
}

void TriangularSolves::forward_together(int s, std::span<double> z) {
  const Supernode one = supernode(L_, s);
  double *const own = z.data() + one.first, *const below = shared_.data();
  for (std::ptrdiff_t c = 0; c < one.width; c += panel_width) {
    const std::ptrdiff_t width = std::min(panel_width, one.width - c), end = c + width;
#pragma omp single
    {
      if (c == 0)
        std::fill_n(below, one.below(), 0.0);
      solve_triangle(one, c, width, own + c);
    }
#pragma omp for schedule(static)
    for (std::ptrdiff_t row = end; row < one.height; row += rows_at_once) {
      const std::ptrdiff_t stop = std::min(row + rows_at_once, one.height),
                           own_stop = std::min(stop, one.width), below_start = std::max(row, one.width);
      if (row < own_stop)
        subtract_product(block(one, row, own_stop - row, c, width), own + c, own + row);
      if (below_start < stop)
        subtract_product(block(one, below_start, stop - below_start, c, width), own + c,
                         below + (below_start - one.width));
    }
  }
#pragma omp single
  add_at(one.rows_below, one.below(), below, z);
}

void TriangularSolves::backward_together(int s, std::span<double> z) {
  const Supernode one = supernode(L_, s);
  double *const own = z.data() + one.first, *const below = shared_.data();
#pragma omp single
  take_at(one.rows_below, one.below(), z, below);
  for (std::ptrdiff_t c = (one.width - 1) / panel_width * panel_width; c >= 0; c -= panel_width) {
    const std::ptrdiff_t width = std::min(panel_width, one.width - c), end = c + width;
#pragma omp for schedule(static)
    for (std::ptrdiff_t j = c; j < end; j += columns_at_once) {
      const std::ptrdiff_t columns = std::min(columns_at_once, end - j);
      subtract_transposed_product(block(one, end, one.width - end, j, columns), own + end, own + j);
      subtract_transposed_product(block(one, one.width, one.below(), j, columns), below, own + j);
    }
#pragma omp single
    solve_transposed_triangle(one, c, width, own + c);
  }
}

void TriangularSolves::forward(std::span<double> z) {
#pragma omp parallel num_threads(static_cast<int>(work_.size()))
  {
    const std::span<double> work = work_[omp_get_thread_num()];
#pragma omp for schedule(dynamic, 1)
    for (std::size_t i = 0; i < subtrees_.size(); ++i)
      forward(subtrees_[i], z, work);
#pragma omp single
    for (const Subtree& subtree : subtrees_) {
      const Supernode root = supernode(L_, subtree.root);
      add_at(root.rows_below, root.below(), outside_.data() + subtree.outside, z);
    }
    for (const Trunk& trunk : trunk_) {
      if (trunk.divided) {
        forward_together(trunk.first, z);
        continue;
      }
#pragma omp single
      for (int s = trunk.first; s <= trunk.last; ++s) {
        const Supernode one = supernode(L_, s);
        signorini::forward(one, z.data() + one.first, work.data());
        add_at(one.rows_below, one.below(), work.data(), z);
      }
    }
  }
}

void TriangularSolves::backward(std::span<double> z) {
#pragma omp parallel num_threads(static_cast<int>(work_.size()))
  {
    const std::span<double> work = work_[omp_get_thread_num()];
    for (const Trunk& trunk : trunk_ | std::views::reverse) {
      if (trunk.divided) {
        backward_together(trunk.first, z);
        continue;
      }
#pragma omp single
      for (int s = trunk.last; s >= trunk.first; --s) {
        const Supernode one = supernode(L_, s);
        take_at(one.rows_below, one.below(), z, work.data());
        signorini::backward(one, z.data() + one.first, work.data());
      }
    }
#pragma omp for schedule(dynamic, 1)
    for (std::size_t i = 0; i < subtrees_.size(); ++i)
      backward(subtrees_[i], z, work);
  }
}

std::size_t TriangularSolves::bytes() const {
  return (inside_.size() + place_.size()) * sizeof(int) +
         (outside_.size() + outside_lanes_.size() + (work_.size() + 1) * shared_.size()) * sizeof(double);
}

} // namespace signorini
