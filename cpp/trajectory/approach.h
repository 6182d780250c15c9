// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/time_profile.h"
#include "step/step.h"
#include "trajectory/step_errors.h"
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace signorini::trajectory {

/// Predicts when a body in flight touches, from its rigid motion, its vibration and the motion of the
/// obstacles; tests whether obstacles and clamps move smoothly within a step (docs/method.md section 11).
class Approach {
public:
  /// Collective. The references must outlive this object. Throws UserError.
  Approach(const step::Stepper& stepper, const scene::Scene& scene, const StepErrors& errors);

  /// The time from `t` (s) until a candidate of an obstacle that is not in contact comes within reach of it,
  /// 0 where one is, infinite if none does before the end. Not collective.
  [[nodiscard]] double until_touch(double t) const;
  /// Whether bodies fly free: no candidate is fixed by clamps.
  [[nodiscard]] bool free() const { return free_; }
  /// Whether obstacles in contact, and clamps, move between two times smoothly enough: like a parabola, up to
  /// `deep` (m) and to a part of their whole motion. Collective.
  [[nodiscard]] bool smooth(double from, double to, double deep, double part) const;

private:
  /// Rigid motion of a candidate along ν: position, velocity, acceleration.
  struct Along {
    double position = 0, velocity = 0, acceleration = 0;
  };
  [[nodiscard]] Along along(std::size_t candidate) const;
  [[nodiscard]] bool held(std::size_t candidate) const;
  [[nodiscard]] double until_moving(std::size_t obstacle, double t) const;

  const step::Stepper& stepper_;
  const StepErrors& errors_;
  bool free_ = true;
  std::vector<std::vector<double>> points_; ///< candidates of each obstacle, for level sets
  std::vector<std::vector<std::unique_ptr<fem::TimeProfile>>> obstacles_; ///< motion of each
  std::vector<std::vector<double>> clamped_;                              ///< points
  std::vector<std::unique_ptr<fem::TimeProfile>> clamps_;
};

/// The least s ≥ 0 at which g + v s + a s²/2 is 0 or less, infinite if there is none.
double first_root(double g, double v, double a);

/// First touch of a body and an obstacle by rigid motion, with the initial velocity and the scene's loads but
/// without deformation and control.
struct FirstTouch {
  double gap = std::numeric_limits<double>::infinity(); ///< the least gap at t = 0, m
  bool flies = false; ///< whether rigid motion or that of the obstacle can close the gap
  double time = std::numeric_limits<double>::infinity(); ///< s; infinite if not before the end
  double speed = 0;                                      ///< speed of approach then, m/s
  double nearest = gap, nearest_time = 0;                ///< the least gap of all times, m, and when, s

  [[nodiscard]] bool occurs() const { return time < std::numeric_limits<double>::infinity(); }
};

/// Returns the first touch of each obstacle of the scene. Loads and obstacles that vary are sampled at 256
/// times. Collective. Throws UserError.
std::vector<FirstTouch> first_touches(const step::Stepper& stepper, const scene::Scene& scene);

/// Describes the first touches, in a line for each obstacle. Collective. Throws UserError.
std::vector<std::string> first_touch_lines(const step::Stepper& stepper, const scene::Scene& scene);

} // namespace signorini::trajectory
