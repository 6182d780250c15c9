// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"

namespace signorini::scene {

/// Free fall of a body that is dropped (initial.drop).
struct Fall {
  std::vector<double> direction; ///< unit vector of gravity, one entry per space dimension
  double acceleration;           ///< m/s²
  double speed;                  ///< at the end of the fall, m/s

  /// Time in which a body that is thrown up with this speed comes down again, s.
  [[nodiscard]] double flight_time() const { return 2 * speed / acceleration; }
};

/// Computes the fall from `height` (m) by a constant `gravity` (m/s²), which must not be zero.
Fall fall(const Components& gravity, double height);
/// Computes the fall of a scene with initial.drop, whose gravity must be constant and not zero.
Fall fall(const Scene& scene);

} // namespace signorini::scene
