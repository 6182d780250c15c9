// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "step/step.h"
#include <limits>
#include <string>
#include <vector>

namespace signorini::trajectory {

/// The least s ≥ 0 at which g + v s + a s²/2 is 0 or less, infinite if there is none.
double first_root(double g, double v, double a);

/// When a body first touches an obstacle if it moves as a rigid one, by its initial velocity and the scene's
/// loads, without its deformation and a control.
struct FirstTouch {
  double gap = std::numeric_limits<double>::infinity(); ///< the least at t = 0, m
  bool flies = false; ///< whether rigid motion or the obstacle's own closes it
  double time = std::numeric_limits<double>::infinity(); ///< s; infinite if not before the end
  double speed = 0;                                      ///< of approach then, m/s
  double nearest = gap, nearest_time = 0;                ///< the least gap of all times, m, and when, s

  [[nodiscard]] bool occurs() const { return time < std::numeric_limits<double>::infinity(); }
};

/// For each obstacle of the scene. Loads and obstacles that vary are sampled at 256 times. Collective. Throws
/// UserError.
std::vector<FirstTouch> first_touches(const step::Stepper& stepper, const scene::Scene& scene);

/// In words, a line for each obstacle. Collective. Throws UserError.
std::vector<std::string> first_touch_lines(const step::Stepper& stepper, const scene::Scene& scene);

} // namespace signorini::trajectory
