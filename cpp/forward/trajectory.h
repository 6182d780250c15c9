#pragma once
#include "forward/step.h"
#include <vector>

namespace signorini::forward {

/// States and contact at t_0…t_N; entry 0 is the initial state, whose candidates count as open.
struct Trajectory {
  petsc::Series y, v; ///< N + 1 vectors of V: displacement (m), velocity (m/s)
  std::vector<contact::ContactState> contact;
  int steps = 0; ///< done so far: entries 0…steps are valid

  /// Room for `count` steps. Collective.
  Trajectory(const Stepper& stepper, int count);

  [[nodiscard]] int capacity() const { return static_cast<int>(y.size()) - 1; }
};

} // namespace signorini::forward
