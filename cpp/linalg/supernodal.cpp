#include "linalg/supernodal.h"
#include <algorithm>
#include <cstddef>

// Debian builds for baseline x86-64; the loops below gain from a second version for wider vector registers.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define SIGNORINI_WIDE __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define SIGNORINI_WIDE
#endif

namespace signorini {

namespace {

/// Supernodes by which prefetching runs ahead: a supernode has a few kilobytes, and memory latency is about
/// the time of one or two.
constexpr std::ptrdiff_t lookahead = 4;
constexpr std::ptrdiff_t cache_line = 64 / sizeof(double);

/// A dense trapezoid of L, column by column: `height` rows, the first `width` of them its diagonal block.
struct Supernode {
  const double* values;
  const int* rows_below;
  std::ptrdiff_t first, width, height;
};

Supernode supernode(const cholmod_factor& L, std::ptrdiff_t s) {
  const auto *super = static_cast<const int*>(L.super), *pi = static_cast<const int*>(L.pi),
             *px = static_cast<const int*>(L.px), *rows = static_cast<const int*>(L.s);
  const std::ptrdiff_t width = super[s + 1] - super[s];
  return {static_cast<const double*>(L.x) + px[s], rows + pi[s] + width, super[s], width, pi[s + 1] - pi[s]};
}

void prefetch(const cholmod_factor& L, std::ptrdiff_t s) {
  if (s < 0 || s >= static_cast<std::ptrdiff_t>(L.nsuper))
    return;
  const Supernode next = supernode(L, s);
  for (std::ptrdiff_t i = 0; i < next.width * next.height; i += cache_line)
    __builtin_prefetch(next.values + i);
}

/// below −= B own, where B are the rows of the supernode below its diagonal block.
SIGNORINI_WIDE void subtract_product(const Supernode& s, const double* __restrict own,
                                     double* __restrict below) {
  const std::ptrdiff_t n = s.height - s.width;
  const double* __restrict column = s.values + s.width;
  std::ptrdiff_t j = 0;
  for (; j + 4 <= s.width; j += 4, column += 4 * s.height) { // four columns for each pass over `below`
    const double *c1 = column + s.height, *c2 = c1 + s.height, *c3 = c2 + s.height;
#pragma omp simd
    for (std::ptrdiff_t i = 0; i < n; ++i)
      below[i] -= own[j] * column[i] + own[j + 1] * c1[i] + own[j + 2] * c2[i] + own[j + 3] * c3[i];
  }
  for (; j < s.width; ++j, column += s.height)
#pragma omp simd
    for (std::ptrdiff_t i = 0; i < n; ++i)
      below[i] -= own[j] * column[i];
}

/// own −= Bᵀ below.
SIGNORINI_WIDE void subtract_transposed_product(const Supernode& s, const double* __restrict below,
                                                double* __restrict own) {
  const std::ptrdiff_t n = s.height - s.width;
  const double* __restrict column = s.values + s.width;
  std::ptrdiff_t j = 0;
  for (; j + 4 <= s.width; j += 4, column += 4 * s.height) {
    const double *c1 = column + s.height, *c2 = c1 + s.height, *c3 = c2 + s.height;
    double d0 = 0, d1 = 0, d2 = 0, d3 = 0;
#pragma omp simd reduction(+ : d0, d1, d2, d3)
    for (std::ptrdiff_t i = 0; i < n; ++i) {
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
  for (; j < s.width; ++j, column += s.height) {
    double d = 0;
#pragma omp simd reduction(+ : d)
    for (std::ptrdiff_t i = 0; i < n; ++i)
      d += column[i] * below[i];
    own[j] -= d;
  }
}

} // namespace

void supernodal_forward(const cholmod_factor& L, std::span<double> z, std::span<double> work) {
  for (std::ptrdiff_t k = 0; k < static_cast<std::ptrdiff_t>(L.nsuper); ++k) {
    prefetch(L, k + lookahead);
    const Supernode s = supernode(L, k);
    double* own = z.data() + s.first;
    for (std::ptrdiff_t j = 0; j < s.width; ++j) {
      const double* column = s.values + j * s.height;
      own[j] /= column[j];
      for (std::ptrdiff_t i = j + 1; i < s.width; ++i)
        own[i] -= column[i] * own[j];
    }
    const std::ptrdiff_t n = s.height - s.width;
    std::fill_n(work.begin(), n, 0.0);
    subtract_product(s, own, work.data());
    for (std::ptrdiff_t i = 0; i < n; ++i)
      z[static_cast<std::size_t>(s.rows_below[i])] += work[static_cast<std::size_t>(i)];
  }
}

void supernodal_backward(const cholmod_factor& L, std::span<double> z, std::span<double> work) {
  for (auto k = static_cast<std::ptrdiff_t>(L.nsuper); k-- > 0;) {
    prefetch(L, k - lookahead);
    const Supernode s = supernode(L, k);
    double* own = z.data() + s.first;
    for (std::ptrdiff_t i = 0; i < s.height - s.width; ++i)
      work[static_cast<std::size_t>(i)] = z[static_cast<std::size_t>(s.rows_below[i])];
    subtract_transposed_product(s, work.data(), own);
    for (std::ptrdiff_t j = s.width; j-- > 0;) {
      const double* column = s.values + j * s.height;
      for (std::ptrdiff_t i = j + 1; i < s.width; ++i)
        own[j] -= column[i] * own[i];
      own[j] /= column[j];
    }
  }
}

} // namespace signorini
