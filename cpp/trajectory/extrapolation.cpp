// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/extrapolation.h"
#include <cmath>
#include <span>

namespace signorini::trajectory {
using petsc::check;

Extrapolation::Extrapolation(const step::Stepper& stepper) : wanted_(stepper.solver().takes_guess()) {
  if (wanted_)
    for (petsc::Vector& x : stored_)
      x = stepper.space().vector();
}

bool Extrapolation::continues(double t) const {
  constexpr double rounding = 1e-6; // of times far from 0
  const double before = times_[0] - times_[1];
  return known_ > 1 && std::abs(t - times_[0] - before) <= rounding * std::abs(before);
}

void Extrapolation::remember(double t, Vec x) {
  if (!wanted_ || (known_ > 0 && times_[0] == t))
    return;
  const double one = t - times_[0], two = t - times_[1];
  // Each difference replaces the one of the next lower order; the oldest vector receives x.
  if (known_ > 0)
    check(VecAXPBY(stored_[0], 1 / one, -1 / one, x));
  if (known_ > 1)
    check(VecAXPBY(stored_[1], 1 / two, -1 / two, stored_[0]));
  if (known_ > 2)
    check(VecAXPBY(stored_[2], one * two, -one * two, stored_[1])); // x minus the parabola's value at t
  check(VecCopy(x, stored_.back()));
  std::ranges::rotate(stored_, stored_.end() - 1);
  equal_ = known_ == 0 ? 0 : continues(t) ? std::min(equal_ + 1, stored) : 1;
  times_ = {t, times_[0], times_[1]};
  known_ = std::min(known_ + 1, points);
  update_products();
  fit_weights();
}

void Extrapolation::update_products() {
  for (std::size_t i = errors - 1; i > 0; --i)
    for (std::size_t j = errors - 1; j >= i; --j)
      products_[i][j] = products_[i - 1][j - 1];
  // One product at a time: the sums of VecMDot would depend on the number of vectors.
  for (int j = 0; j < known_errors(); ++j)
    check(VecDot(stored_[points], stored_[static_cast<std::size_t>(points + j)],
                 &products_[0][static_cast<std::size_t>(j)]));
}

void Extrapolation::fit_weights() {
  constexpr double rounding = 1e-14; // of products
  weights_ = 0;
  normal_.clear();
  // A guess by j weights is off by the misfit, and by the noise of the errors times the weights.
  double least = products_[0][0];
  for (int j = 1; j < known_errors(); ++j) {
    const auto n = static_cast<std::size_t>(j);
    std::array<double, lags> column{}, w{};
    for (std::size_t i = 1; i < n; ++i)
      column[i - 1] = products_[i][n];
    if (!normal_.append({column.data(), n - 1}, products_[n][n], rounding))
      return;
    std::copy_n(products_[0].begin() + 1, n, w.begin());
    normal_.solve({w.data(), n});
    double misfit = products_[0][0], square = 1;
    for (std::size_t i = 0; i < n; ++i) {
      misfit -= w[i] * products_[0][i + 1];
      square += w[i] * w[i];
    }
    if (const double size = std::max(misfit, rounding * products_[0][0]) * square; size < least) {
      least = size;
      w_ = w;
      weights_ = j;
    }
  }
}

void Extrapolation::guess(double t, Vec out) const {
  if (known_ == 0)
    return;
  const double one = t - times_[0];
  std::array<PetscScalar, stored> factors{1, one, one * (t - times_[1])};
  std::array<Vec, stored> vectors{};
  PetscInt count = known_;
  if (known_ == points && continues(t)) {
    std::copy_n(w_.begin(), weights_, factors.begin() + points);
    count += weights_;
  }
  std::ranges::copy(stored_, vectors.begin());
  check(VecCopy(stored_[0], out));
  check(VecMAXPY(out, count - 1, &factors[1], &vectors[1]));
}

void Extrapolation::take(const Extrapolation& other) {
  known_ = other.known_;
  equal_ = other.equal_;
  times_ = other.times_;
  products_ = other.products_;
  w_ = other.w_;
  weights_ = other.weights_;
  for (int i = 0; i < known_ + known_errors(); ++i)
    check(VecCopy(other.stored_[static_cast<std::size_t>(i)], stored_[static_cast<std::size_t>(i)]));
}

} // namespace signorini::trajectory
