// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/lane_kernels.h"

// Debian builds for baseline x86-64; the kernels have versions for wider vector registers.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define SIGNORINI_WIDEST __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define SIGNORINI_WIDEST
#endif
#define SIGNORINI_INLINE inline __attribute__((always_inline))

namespace signorini {
namespace {

/// Values of one unknown for eight right-hand sides.
using Lanes __attribute__((vector_size(64), aligned(8), may_alias)) = double;

template <int V>
SIGNORINI_INLINE const Lanes* at(const double* x, std::ptrdiff_t unknown) {
  return reinterpret_cast<const Lanes*>(x + unknown * V * 8);
}
template <int V>
SIGNORINI_INLINE Lanes* at(double* x, std::ptrdiff_t unknown) {
  return reinterpret_cast<Lanes*>(x + unknown * V * 8);
}

template <int V>
SIGNORINI_INLINE void solve(const FactorBlock& T, double* own) {
  for (std::ptrdiff_t j = 0; j < T.columns; ++j) {
    const double* column = T.values + j * T.stride;
    Lanes z[V];
    for (int v = 0; v < V; ++v) {
      z[v] = at<V>(own, j)[v] / column[j];
      at<V>(own, j)[v] = z[v];
    }
    for (std::ptrdiff_t i = j + 1; i < T.columns; ++i)
      for (int v = 0; v < V; ++v)
        at<V>(own, i)[v] -= column[i] * z[v];
  }
}

template <int V>
SIGNORINI_INLINE void solve_transposed(const FactorBlock& T, double* own) {
  for (std::ptrdiff_t j = T.columns; j-- > 0;) {
    const double* column = T.values + j * T.stride;
    Lanes z[V];
    for (int v = 0; v < V; ++v)
      z[v] = at<V>(own, j)[v];
    for (std::ptrdiff_t i = j + 1; i < T.columns; ++i)
      for (int v = 0; v < V; ++v)
        z[v] -= column[i] * at<V>(own, i)[v];
    for (int v = 0; v < V; ++v)
      at<V>(own, j)[v] = z[v] / column[j];
  }
}

/// T rows of a block.
template <int V, int T>
SIGNORINI_INLINE void subtract_rows(const double* first, const FactorBlock& B, const double* own,
                                    const int* row, std::ptrdiff_t begin, double* to) {
  Lanes sum[T][V] = {};
  for (std::ptrdiff_t j = 0; j < B.columns; ++j) {
    const double* column = first + j * B.stride;
    for (int t = 0; t < T; ++t)
      for (int v = 0; v < V; ++v)
        sum[t][v] += column[t] * at<V>(own, j)[v];
  }
  for (int t = 0; t < T; ++t)
    for (int v = 0; v < V; ++v)
      at<V>(to, row ? row[begin + t] : begin + t)[v] -= sum[t][v];
}

template <int V>
SIGNORINI_INLINE void subtract(const FactorBlock& B, const double* own, const int* row, double* to) {
  constexpr int tile = 8;
  std::ptrdiff_t i = 0;
  for (; i + tile <= B.rows; i += tile)
    subtract_rows<V, tile>(B.values + i, B, own, row, i, to);
  for (; i + 2 <= B.rows; i += 2)
    subtract_rows<V, 2>(B.values + i, B, own, row, i, to);
  for (; i < B.rows; ++i)
    subtract_rows<V, 1>(B.values + i, B, own, row, i, to);
}

/// T columns of a block.
template <int V, int T>
SIGNORINI_INLINE void subtract_columns(const double* first, const FactorBlock& B, const double* from,
                                       const int* row, double* own) {
  Lanes sum[T][V] = {};
  for (std::ptrdiff_t i = 0; i < B.rows; ++i) {
    const Lanes* z = at<V>(from, row ? row[i] : i);
    for (int t = 0; t < T; ++t)
      for (int v = 0; v < V; ++v)
        sum[t][v] += first[t * B.stride + i] * z[v];
  }
  for (int t = 0; t < T; ++t)
    for (int v = 0; v < V; ++v)
      at<V>(own, t)[v] -= sum[t][v];
}

template <int V>
SIGNORINI_INLINE void subtract_transposed(const FactorBlock& B, const double* from, const int* row,
                                          double* own) {
  constexpr int tile = 8;
  std::ptrdiff_t j = 0;
  for (; j + tile <= B.columns; j += tile)
    subtract_columns<V, tile>(B.values + j * B.stride, B, from, row, own + j * V * 8);
  for (; j + 2 <= B.columns; j += 2)
    subtract_columns<V, 2>(B.values + j * B.stride, B, from, row, own + j * V * 8);
  for (; j < B.columns; ++j)
    subtract_columns<V, 1>(B.values + j * B.stride, B, from, row, own + j * V * 8);
}

/// Adds the product with one row of a matrix to `sum`.
template <int V, int size>
SIGNORINI_INLINE void add_row(const BlockRows& A, int row, const double* x, Lanes (&sum)[size][V]) {
  for (int e = A.begin[row]; e < A.begin[row + 1]; ++e) {
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(A.column[e]) * size;
    if (A.numbers == 1) {
      for (int c = 0; c < size; ++c)
        for (int v = 0; v < V; ++v)
          sum[c][v] += A.values[e] * at<V>(x, first + c)[v];
      continue;
    }
    const double* const block = A.values + static_cast<std::ptrdiff_t>(e) * size * size;
    for (int c = 0; c < size; ++c)
      for (int r = 0; r < size; ++r)
        for (int v = 0; v < V; ++v)
          sum[r][v] += block[r * size + c] * at<V>(x, first + c)[v];
  }
}

template <int V, int size>
SIGNORINI_INLINE void multiply(const BlockRows& R, const BlockRows& M, int first, int end, const double* x,
                               const double* w, double* r) {
  for (int row = first; row < end; ++row) {
    Lanes sum[size][V] = {};
    add_row<V, size>(M, row, w, sum);
    add_row<V, size>(R, row, x, sum);
    for (int c = 0; c < size; ++c)
      for (int v = 0; v < V; ++v)
        at<V>(r, static_cast<std::ptrdiff_t>(row) * size + c)[v] = sum[c][v];
  }
}

template <int V>
SIGNORINI_INLINE void multiply(const BlockRows& R, const BlockRows& M, int size, int first, int end,
                               const double* x, const double* w, double* r) {
  size == 2 ? multiply<V, 2>(R, M, first, end, x, w, r) : multiply<V, 3>(R, M, first, end, x, w, r);
}

} // namespace

SIGNORINI_WIDEST void multiply_lanes(const BlockRows& R, const BlockRows& M, int size, int first, int end,
                                     std::ptrdiff_t lanes, const double* x, const double* w, double* r) {
  lanes == narrow_lanes ? multiply<1>(R, M, size, first, end, x, w, r)
                        : multiply<2>(R, M, size, first, end, x, w, r);
}
SIGNORINI_WIDEST void solve_lanes(const FactorBlock& T, std::ptrdiff_t lanes, double* own) {
  lanes == narrow_lanes ? solve<1>(T, own) : solve<2>(T, own);
}
SIGNORINI_WIDEST void solve_lanes_transposed(const FactorBlock& T, std::ptrdiff_t lanes, double* own) {
  lanes == narrow_lanes ? solve_transposed<1>(T, own) : solve_transposed<2>(T, own);
}
SIGNORINI_WIDEST void subtract_lanes(const FactorBlock& B, std::ptrdiff_t lanes, const double* own,
                                     const int* row, double* to) {
  lanes == narrow_lanes ? subtract<1>(B, own, row, to) : subtract<2>(B, own, row, to);
}
SIGNORINI_WIDEST void subtract_lanes_transposed(const FactorBlock& B, std::ptrdiff_t lanes,
                                                const double* from, const int* row, double* own) {
  lanes == narrow_lanes ? subtract_transposed<1>(B, from, row, own)
                        : subtract_transposed<2>(B, from, row, own);
}

} // namespace signorini
