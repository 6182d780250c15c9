// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/check/switches.h"
#include <algorithm>
#include <iterator>

namespace signorini::drivers {

namespace {

/// Number of candidates that are in exactly one of two ascending sets.
int apart(const contact::ActiveSet& a, const contact::ActiveSet& b) {
  contact::ActiveSet difference;
  std::ranges::set_symmetric_difference(a, b, std::back_inserter(difference));
  return static_cast<int>(difference.size());
}

/// Number of candidates that are active in both of two states and stick in one and slip in the other, or
/// touch in one alone.
int otherwise_moving(const contact::ContactLinearisation& a, const contact::ContactLinearisation& b) {
  int count = 0;
  for (std::size_t i = 0; i < a.equations.size(); ++i) {
    const auto found = std::ranges::lower_bound(b.active, a.active[i]);
    const auto j = static_cast<std::size_t>(found - b.active.begin());
    if (found != b.active.end() && *found == a.active[i])
      count += a.motion(i) != b.motion(j) || a.closed(i) != b.closed(j);
  }
  return count;
}

} // namespace

Switches switches(const ContactHistory& a, const ContactHistory& b) {
  Switches sum;
  for (std::size_t k = 1; k < std::min(a.size(), b.size()); ++k) {
    const int here = apart(a[k].active, b[k].active) + apart(a[k].predictor, b[k].predictor) +
                     otherwise_moving(a[k], b[k]);
    sum.steps += here > 0;
    sum.candidates += here;
  }
  return sum;
}

int kinks(const ContactHistory& contact) {
  int sum = 0;
  for (const contact::ContactLinearisation& state : contact)
    sum += static_cast<int>(state.kinks());
  return sum;
}

} // namespace signorini::drivers
