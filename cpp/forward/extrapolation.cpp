#include "forward/extrapolation.h"
#include <algorithm>

namespace signorini::forward {
using petsc::check;

Extrapolation::Extrapolation(const Stepper& stepper) : wanted_(stepper.solver().takes_guess()) {
  if (wanted_)
    for (petsc::Vector& x : last_)
      x = stepper.space().vector();
}

void Extrapolation::remember(Vec x) {
  if (!wanted_)
    return;
  std::swap(last_[1], last_[2]);
  std::swap(last_[0], last_[1]);
  check(VecCopy(x, last_[0]));
  known_ = std::min(known_ + 1, most);
}

void Extrapolation::guess(Vec out) const {
  if (known_ == 0)
    return;
  check(VecCopy(last_[0], out));
  if (known_ == 2)
    check(VecAXPBY(out, -1, 2, last_[1]));
  else if (known_ == 3)
    check(VecAXPBYPCZ(out, -3, 1, 3, last_[1], last_[2]));
}

void Extrapolation::take(const Extrapolation& other) {
  known_ = other.known_;
  for (int i = 0; i < known_; ++i)
    check(VecCopy(other.last_[static_cast<std::size_t>(i)], last_[static_cast<std::size_t>(i)]));
}

} // namespace signorini::forward
