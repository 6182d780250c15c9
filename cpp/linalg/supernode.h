// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cholmod.h>
#include <cstddef>

/// Access to the supernodes of CHOLMOD's factors (real, 32-bit indices).
namespace signorini {

/// Number of columns of a supernode that are solved before the rows below them are updated.
constexpr std::ptrdiff_t panel_width = 64;

/// Dense trapezoid of L, stored by columns: `height` rows; the first `width` form the diagonal block.
struct Supernode {
  const double* values;
  const int* rows_below;
  std::ptrdiff_t first, width, height;
  [[nodiscard]] std::ptrdiff_t below() const { return height - width; }
};

inline int count(const cholmod_factor& L) { return static_cast<int>(L.nsuper); }

inline Supernode supernode(const cholmod_factor& L, std::ptrdiff_t s) {
  const auto *super = static_cast<const int*>(L.super), *pi = static_cast<const int*>(L.pi),
             *px = static_cast<const int*>(L.px), *rows = static_cast<const int*>(L.s);
  const std::ptrdiff_t width = super[s + 1] - super[s];
  return {static_cast<const double*>(L.x) + px[s], rows + pi[s] + width, super[s], width, pi[s + 1] - pi[s]};
}

} // namespace signorini
