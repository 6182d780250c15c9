#include "forward/schedule.h"
#include <algorithm>

namespace signorini::forward {

namespace {

/// The longest motion that s slots take back with no step made more than r times: C(s + r + 1, r) − 1, or
/// some number above every number of steps.
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
  // The slots below must do for what is before it, one fewer for what is behind, each with the repeats that
  // are left.
  return static_cast<int>(std::min(1 + reach(slots, repeats - 1), steps - reach(slots - 1, repeats - 1)));
}

long steps_made(int steps, int slots) {
  long made = 0; // a step is made once more for each number of repeats that does not reach it
  for (int repeats = 0; reach(slots, repeats) < steps; ++repeats)
    made += steps - reach(slots, repeats);
  return made;
}

} // namespace signorini::forward
