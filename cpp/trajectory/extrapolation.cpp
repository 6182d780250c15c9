// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/extrapolation.h"
#include <algorithm>

namespace signorini::trajectory {
using petsc::check;

Extrapolation::Extrapolation(const step::Stepper& stepper) : wanted_(stepper.solver().takes_guess()) {
  if (wanted_)
    for (petsc::Vector& x : last_)
      x = stepper.space().vector();
}

void Extrapolation::remember(double t, Vec x) {
  if (!wanted_ || (known_ > 0 && times_.front() == t))
    return;
  std::swap(last_[1], last_[2]);
  std::swap(last_[0], last_[1]);
  times_ = {t, times_[0], times_[1]};
  check(VecCopy(x, last_[0]));
  known_ = std::min(known_ + 1, most);
}

void Extrapolation::guess(double t, Vec out) const {
  for (int i = 0; i < known_; ++i) { // Lagrange's polynomials
    double weight = 1;
    for (int j = 0; j < known_; ++j)
      if (j != i)
        weight *= (t - times_[static_cast<std::size_t>(j)]) /
                  (times_[static_cast<std::size_t>(i)] - times_[static_cast<std::size_t>(j)]);
    check(VecAXPBY(out, weight, i == 0 ? 0 : 1, last_[static_cast<std::size_t>(i)]));
  }
}

void Extrapolation::take(const Extrapolation& other) {
  known_ = other.known_;
  times_ = other.times_;
  for (int i = 0; i < known_; ++i)
    check(VecCopy(other.last_[static_cast<std::size_t>(i)], last_[static_cast<std::size_t>(i)]));
}

} // namespace signorini::trajectory
