// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/lcp/lemke.h"
#include "linalg/dense.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace signorini::contact {

namespace {

/// Dictionary of the method: basic variables in terms of the others, w − M z − z0 = q.
class Tableau {
public:
  Tableau(std::span<const double> M, std::span<const double> q)
      : n_(q.size()), width_(2 * n_ + 2), entries_(n_ * width_), basis_(n_) {
    std::iota(basis_.begin(), basis_.end(), std::size_t{0});
    for (std::size_t i = 0; i < n_; ++i) {
      const std::span<double> row = this->row(i);
      row[i] = 1;
      for (std::size_t j = 0; j < n_; ++j)
        row[n_ + j] = -M[i * n_ + j];
      row[artificial()] = -1;
      row[width_ - 1] = q[i];
    }
  }

  /// Column of the artificial variable z0.
  [[nodiscard]] std::size_t artificial() const { return 2 * n_; }
  [[nodiscard]] std::size_t partner(std::size_t variable) const {
    return variable < n_ ? variable + n_ : variable - n_;
  }
  [[nodiscard]] double value(std::size_t i) { return row(i)[width_ - 1]; }
  [[nodiscard]] std::size_t basic(std::size_t i) const { return basis_[i]; }

  /// Row that leaves when `column` enters; n if none limits it. Among equal rows, that of z0.
  [[nodiscard]] std::size_t leaving(std::size_t column) {
    constexpr double least_pivot = 1e-11, alike = 1e-12;
    std::size_t found = n_;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < n_; ++i) {
      const double pivot = row(i)[column];
      if (pivot <= least_pivot)
        continue;
      const double ratio = std::max(value(i), 0.0) / pivot;
      if (ratio < least - alike || (ratio <= least + alike && basis_[i] == artificial()) || found == n_) {
        found = i;
        least = std::min(least, ratio);
      }
    }
    return found;
  }

  /// Makes the variable of `column` basic in a row; returns the variable that leaves.
  std::size_t pivot(std::size_t at, std::size_t column) {
    scale(1 / row(at)[column], row(at));
    for (std::size_t i = 0; i < n_; ++i)
      if (const double factor = row(i)[column]; i != at && factor != 0)
        axpy(-factor, row(at), row(i));
    return std::exchange(basis_[at], column);
  }

private:
  [[nodiscard]] std::span<double> row(std::size_t i) { return {&entries_[i * width_], width_}; }

  std::size_t n_, width_;
  std::vector<double> entries_; ///< n × (2 n + 2), row by row: w, z, z0, right-hand side
  std::vector<std::size_t> basis_;
};

} // namespace

std::vector<double> lemke(std::span<const double> M, std::span<const double> q) {
  const std::size_t n = q.size();
  std::vector<double> z(n);
  const auto lowest = static_cast<std::size_t>(std::ranges::min_element(q) - q.begin());
  if (n == 0 || q[lowest] >= 0)
    return z;
  const double unit = -q[lowest];
  std::vector<double> scaled(q.begin(), q.end());
  scale(1 / unit, scaled);
  Tableau tableau(M, scaled);
  std::size_t entering = tableau.partner(tableau.pivot(lowest, tableau.artificial()));
  const std::size_t most = 50 * n;
  for (std::size_t i = 0; i < most; ++i) {
    const std::size_t at = tableau.leaving(entering);
    if (at == n)
      return {};
    const std::size_t left = tableau.pivot(at, entering);
    if (left == tableau.artificial()) {
      for (std::size_t j = 0; j < n; ++j)
        if (const std::size_t variable = tableau.basic(j); variable >= n && variable < 2 * n)
          z[variable - n] = unit * std::max(tableau.value(j), 0.0);
      return z;
    }
    entering = tableau.partner(left);
  }
  return {};
}

} // namespace signorini::contact
