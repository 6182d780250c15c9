// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/binomial_checkpointing.h"
#include <algorithm>

namespace signorini::trajectory {

namespace {

/// The longest motion that can be reversed with s slots and no step made more than r times: C(s + r + 1, r) −
/// 1, or some number larger than any number of steps.
long reach(int slots, int repeats) {
  constexpr long enough = 1'000'000'000;
  long binomial = 1;
  for (int i = 1; i <= repeats && binomial < enough; ++i)
    binomial = binomial * (slots + 1 + i) / i;
  return binomial - 1;
}

} // namespace

int next_checkpoint(int steps, int slots) {
  int repeats = 1;
  while (reach(slots, repeats) < steps)
    ++repeats;
  // The steps before the checkpoint must be reversible with all slots, those after it with one fewer, each
  // with the remaining repeats.
  return static_cast<int>(std::min(1 + reach(slots, repeats - 1), steps - reach(slots - 1, repeats - 1)));
}

long steps_made(int steps, int slots) {
  long made = 0; // each number of repeats that falls short adds one run of the steps beyond its reach
  for (int repeats = 0; reach(slots, repeats) < steps; ++repeats)
    made += steps - reach(slots, repeats);
  return made;
}

} // namespace signorini::trajectory
