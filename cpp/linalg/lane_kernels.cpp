// SPDX-License-Identifier: GPL-3.0-or-later
#include "linalg/lane_kernels.h"
#include <algorithm>
#include <array>
#include <limits>

#define SIGNORINI_INLINE inline __attribute__((always_inline))

namespace signorini {
namespace {

/// Values of one unknown for W right-hand sides, in a vector register.
template <int W>
struct Register {
  using Lanes __attribute__((vector_size(W * sizeof(double)), aligned(sizeof(double)), may_alias)) = double;
};

/// Shape of the kernels for registers of W numbers. `L`: number of lanes.
template <int W, int L>
struct Shape {
  using Lanes = typename Register<W>::Lanes;
  static constexpr int all = L / W;           ///< registers for all lanes
  static constexpr int V = all < 2 ? all : 2; ///< registers for the lanes of a group
  static constexpr int groups = all / V;      ///< groups, one after another
  static constexpr int tile = W == 8 ? 8
                              : W == 4
                                  ? 6
                                  : 4; ///< rows or columns at once, whose sums have registers of 32, 16, 16

  static SIGNORINI_INLINE const Lanes* at(const double* x, std::ptrdiff_t unknown, int group = 0) {
    return reinterpret_cast<const Lanes*>(x + unknown * L + group * V * W);
  }
  static SIGNORINI_INLINE Lanes* at(double* x, std::ptrdiff_t unknown, int group = 0) {
    return reinterpret_cast<Lanes*>(x + unknown * L + group * V * W);
  }
};

template <class S>
SIGNORINI_INLINE void solve(const FactorBlock& T, double* own) {
  for (std::ptrdiff_t j = 0; j < T.columns; ++j) {
    const double* column = T.values + j * T.stride;
    typename S::Lanes z[S::all];
    for (int v = 0; v < S::all; ++v) {
      z[v] = S::at(own, j)[v] / column[j];
      S::at(own, j)[v] = z[v];
    }
    for (std::ptrdiff_t i = j + 1; i < T.columns; ++i)
      for (int v = 0; v < S::all; ++v)
        S::at(own, i)[v] -= column[i] * z[v];
  }
}

template <class S>
SIGNORINI_INLINE void solve_transposed(const FactorBlock& T, double* own) {
  for (std::ptrdiff_t j = T.columns; j-- > 0;) {
    const double* column = T.values + j * T.stride;
    typename S::Lanes z[S::all];
    for (int v = 0; v < S::all; ++v)
      z[v] = S::at(own, j)[v];
    for (std::ptrdiff_t i = j + 1; i < T.columns; ++i)
      for (int v = 0; v < S::all; ++v)
        z[v] -= column[i] * S::at(own, i)[v];
    for (int v = 0; v < S::all; ++v)
      S::at(own, j)[v] = z[v] / column[j];
  }
}

/// T rows of a block, from row `begin` on.
template <class S, int T>
SIGNORINI_INLINE void subtract_rows(const FactorBlock& B, const double* own, const int* row,
                                    std::ptrdiff_t begin, double* to) {
  for (int group = 0; group < S::groups; ++group) {
    typename S::Lanes sum[T][S::V] = {};
    for (std::ptrdiff_t j = 0; j < B.columns; ++j) {
      const double* column = B.values + begin + j * B.stride;
      for (int t = 0; t < T; ++t)
        for (int v = 0; v < S::V; ++v)
          sum[t][v] += column[t] * S::at(own, j, group)[v];
    }
    for (int t = 0; t < T; ++t)
      for (int v = 0; v < S::V; ++v)
        S::at(to, row ? row[begin + t] : begin + t, group)[v] -= sum[t][v];
  }
}

template <class S>
SIGNORINI_INLINE void subtract(const FactorBlock& B, const double* own, const int* row, double* to) {
  std::ptrdiff_t i = 0;
  for (; i + S::tile <= B.rows; i += S::tile)
    subtract_rows<S, S::tile>(B, own, row, i, to);
  for (; i + 2 <= B.rows; i += 2)
    subtract_rows<S, 2>(B, own, row, i, to);
  for (; i < B.rows; ++i)
    subtract_rows<S, 1>(B, own, row, i, to);
}

/// T columns of a block, from column `begin` on.
template <class S, int T>
SIGNORINI_INLINE void subtract_columns(const FactorBlock& B, const double* from, const int* row,
                                       std::ptrdiff_t begin, double* own) {
  const double* first = B.values + begin * B.stride;
  for (int group = 0; group < S::groups; ++group) {
    typename S::Lanes sum[T][S::V] = {};
    for (std::ptrdiff_t i = 0; i < B.rows; ++i) {
      const typename S::Lanes* z = S::at(from, row ? row[i] : i, group);
      for (int t = 0; t < T; ++t)
        for (int v = 0; v < S::V; ++v)
          sum[t][v] += first[t * B.stride + i] * z[v];
    }
    for (int t = 0; t < T; ++t)
      for (int v = 0; v < S::V; ++v)
        S::at(own, begin + t, group)[v] -= sum[t][v];
  }
}

template <class S>
SIGNORINI_INLINE void subtract_transposed(const FactorBlock& B, const double* from, const int* row,
                                          double* own) {
  std::ptrdiff_t j = 0;
  for (; j + S::tile <= B.columns; j += S::tile)
    subtract_columns<S, S::tile>(B, from, row, j, own);
  for (; j + 2 <= B.columns; j += 2)
    subtract_columns<S, 2>(B, from, row, j, own);
  for (; j < B.columns; ++j)
    subtract_columns<S, 1>(B, from, row, j, own);
}

/// Adds the product with one row of a matrix to `sum`.
template <class S, int size>
SIGNORINI_INLINE void add_row(const BlockRows& A, int row, const double* x, int group,
                              typename S::Lanes (&sum)[size][S::V]) {
  for (int e = A.begin[row]; e < A.begin[row + 1]; ++e) {
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(A.column[e]) * size;
    if (A.numbers == 1) {
      for (int c = 0; c < size; ++c)
        for (int v = 0; v < S::V; ++v)
          sum[c][v] += A.values[e] * S::at(x, first + c, group)[v];
      continue;
    }
    const double* const block = A.values + static_cast<std::ptrdiff_t>(e) * size * size;
    for (int c = 0; c < size; ++c)
      for (int r = 0; r < size; ++r)
        for (int v = 0; v < S::V; ++v)
          sum[r][v] += block[r * size + c] * S::at(x, first + c, group)[v];
  }
}

template <class S, int size>
SIGNORINI_INLINE void multiply(const BlockRows& R, const BlockRows& M, int first, int end, const double* x,
                               const double* w, double* r) {
  for (int row = first; row < end; ++row)
    for (int group = 0; group < S::groups; ++group) {
      typename S::Lanes sum[size][S::V] = {};
      add_row<S, size>(M, row, w, group, sum);
      add_row<S, size>(R, row, x, group, sum);
      for (int c = 0; c < size; ++c)
        for (int v = 0; v < S::V; ++v)
          S::at(r, static_cast<std::ptrdiff_t>(row) * size + c, group)[v] = sum[c][v];
    }
}

template <class S>
SIGNORINI_INLINE void multiply(const BlockRows& R, const BlockRows& M, int size, int first, int end,
                               const double* x, const double* w, double* r) {
  size == 2 ? multiply<S, 2>(R, M, first, end, x, w, r) : multiply<S, 3>(R, M, first, end, x, w, r);
}

/// Kernels for one width of the registers.
struct Kernels {
  int width;
  bool (*supported)();
  decltype(multiply_lanes)* multiply;
  decltype(solve_lanes)*solve, *solve_transposed;
  decltype(subtract_lanes)* subtract;
  decltype(subtract_lanes_transposed)* subtract_transposed;
};

// Defines the kernels for registers of W numbers, with the instructions of TARGET, which is an attribute.
// NOLINTBEGIN(bugprone-macro-parentheses)
#define SIGNORINI_KERNELS(NAME, W, TARGET, SUPPORTED)                                                        \
  TARGET void multiply_##NAME(const BlockRows& R, const BlockRows& M, int size, int first, int end,          \
                              std::ptrdiff_t lanes, const double* x, const double* w, double* r) {           \
    lanes == narrow_lanes ? multiply<Shape<W, narrow_lanes>>(R, M, size, first, end, x, w, r)                \
                          : multiply<Shape<W, wide_lanes>>(R, M, size, first, end, x, w, r);                 \
  }                                                                                                          \
  TARGET void solve_##NAME(const FactorBlock& T, std::ptrdiff_t lanes, double* own) {                        \
    lanes == narrow_lanes ? solve<Shape<W, narrow_lanes>>(T, own) : solve<Shape<W, wide_lanes>>(T, own);     \
  }                                                                                                          \
  TARGET void solve_transposed_##NAME(const FactorBlock& T, std::ptrdiff_t lanes, double* own) {             \
    lanes == narrow_lanes ? solve_transposed<Shape<W, narrow_lanes>>(T, own)                                 \
                          : solve_transposed<Shape<W, wide_lanes>>(T, own);                                  \
  }                                                                                                          \
  TARGET void subtract_##NAME(const FactorBlock& B, std::ptrdiff_t lanes, const double* own, const int* row, \
                              double* to) {                                                                  \
    lanes == narrow_lanes ? subtract<Shape<W, narrow_lanes>>(B, own, row, to)                                \
                          : subtract<Shape<W, wide_lanes>>(B, own, row, to);                                 \
  }                                                                                                          \
  TARGET void subtract_transposed_##NAME(const FactorBlock& B, std::ptrdiff_t lanes, const double* from,     \
                                         const int* row, double* own) {                                      \
    lanes == narrow_lanes ? subtract_transposed<Shape<W, narrow_lanes>>(B, from, row, own)                   \
                          : subtract_transposed<Shape<W, wide_lanes>>(B, from, row, own);                    \
  }                                                                                                          \
  constexpr Kernels NAME {                                                                                   \
    W, [] { return static_cast<bool>(SUPPORTED); }, multiply_##NAME, solve_##NAME, solve_transposed_##NAME,  \
        subtract_##NAME, subtract_transposed_##NAME                                                          \
  }
// NOLINTEND(bugprone-macro-parentheses)

SIGNORINI_KERNELS(baseline, 2, , true);
// Debian builds for baseline x86-64.
#if defined(__x86_64__) && defined(__GNUC__)
SIGNORINI_KERNELS(x86_64_v3, 4, __attribute__((target("arch=x86-64-v3"))),
                  __builtin_cpu_supports("x86-64-v3"));
SIGNORINI_KERNELS(x86_64_v4, 8, __attribute__((target("arch=x86-64-v4"))),
                  __builtin_cpu_supports("x86-64-v4"));
constexpr std::array all_kernels{&x86_64_v4, &x86_64_v3, &baseline};
#else
constexpr std::array all_kernels{&baseline};
#endif

/// The widest kernels for registers of at most `limit` numbers that the machine supports.
const Kernels* widest(int limit) {
  return *std::ranges::find_if(all_kernels, [&](const Kernels* one) {
    return one == &baseline || (one->width <= limit && one->supported());
  });
}

const Kernels* kernels = widest(std::numeric_limits<int>::max());

} // namespace

int limit_lane_registers(int limit) {
  kernels = widest(limit);
  return kernels->width;
}

void multiply_lanes(const BlockRows& R, const BlockRows& M, int size, int first, int end,
                    std::ptrdiff_t lanes, const double* x, const double* w, double* r) {
  kernels->multiply(R, M, size, first, end, lanes, x, w, r);
}
void solve_lanes(const FactorBlock& T, std::ptrdiff_t lanes, double* own) { kernels->solve(T, lanes, own); }
void solve_lanes_transposed(const FactorBlock& T, std::ptrdiff_t lanes, double* own) {
  kernels->solve_transposed(T, lanes, own);
}
void subtract_lanes(const FactorBlock& B, std::ptrdiff_t lanes, const double* own, const int* row,
                    double* to) {
  kernels->subtract(B, lanes, own, row, to);
}
void subtract_lanes_transposed(const FactorBlock& B, std::ptrdiff_t lanes, const double* from, const int* row,
                               double* own) {
  kernels->subtract_transposed(B, lanes, from, row, own);
}

} // namespace signorini
