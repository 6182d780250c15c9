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

/// Predicts when a body in flight touches an obstacle, from its rigid motion, its vibration and the
/// obstacles' motion. Also tests whether obstacles and clamps move smoothly within a step (docs/method.md
/// section 11).
class Approach {
public:
  /// Collects the moving obstacles and clamps of `scene`. `errors` provides rigid motion and vibration.
  /// Collective. The references must outlive this object. Throws UserError.
  Approach(const step::Stepper& stepper, const scene::Scene& scene, const StepErrors& errors);

  /// Returns the time from `t` (s) until a candidate comes within the vibration's reach (StepErrors::reach())
  /// of an obstacle that is not in contact. 0 if a candidate is within reach at `t`, infinite if none comes
  /// within reach before the end of the motion. Not collective.
  [[nodiscard]] double until_touch(double t) const;
  /// Returns whether every candidate can move along its normal by a rigid motion that the clamps permit.
  [[nodiscard]] bool all_candidates_movable() const { return all_candidates_movable_; }
  /// Returns whether moving clamps, and moving obstacles in contact, nearly follow a parabola between two
  /// times (s). An obstacle may deviate by `obstacle_tolerance` (m), a clamp by the fraction `clamp_fraction`
  /// of its range of motion. Collective.
  [[nodiscard]] bool smooth(double from, double to, double obstacle_tolerance, double clamp_fraction) const;

private:
  /// Rigid motion of a candidate along its normal ν: displacement (m), velocity (m/s), acceleration (m/s²).
  struct Along {
    double position = 0, velocity = 0, acceleration = 0;
  };
  [[nodiscard]] Along along(std::size_t candidate) const;
  /// Returns whether no rigid motion that clamps permit moves the candidate along ν.
  [[nodiscard]] bool immovable(std::size_t candidate) const;
  [[nodiscard]] double until_moving(std::size_t obstacle, double t) const;

  const step::Stepper& stepper_;
  const StepErrors& errors_;
  bool all_candidates_movable_ = true;
  std::vector<std::vector<double>> points_; ///< points of each obstacle's candidates (candidates × 3), m
  /// Time-dependent points, radii and distances of each obstacle; none for an obstacle at rest.
  std::vector<std::vector<std::unique_ptr<fem::TimeProfile>>> obstacles_;
  std::vector<std::vector<double>> clamped_; ///< points of each moving clamp (nodes × 3), m
  std::vector<std::unique_ptr<fem::TimeProfile>> clamps_;
};

/// Returns the least s ≥ 0 with g + v s + a s²/2 ≤ 0; infinite if there is none.
double first_root(double g, double v, double a);

/// First touch of the body and an obstacle by rigid motion under the initial velocity and the scene's loads,
/// without deformation and without control.
struct FirstTouch {
  double gap = std::numeric_limits<double>::infinity(); ///< least gap of a candidate at t = 0, m
  bool flies = false; ///< whether rigid motion of the body or motion of the obstacle can close the gap
  double time = std::numeric_limits<double>::infinity(); ///< time of the touch, s; infinite if none occurs
                                                         ///< before the end
  double speed = 0;                                      ///< speed of approach at the touch, m/s
  double nearest = gap, nearest_time = 0;                ///< least gap over the motion, m, and its time, s

  [[nodiscard]] bool occurs() const { return time < std::numeric_limits<double>::infinity(); }
};

/// Returns the first touch of each obstacle of the scene. Loads and moving obstacles are sampled in 256
/// intervals. Collective. Throws UserError.
std::vector<FirstTouch> first_touches(const step::Stepper& stepper, const scene::Scene& scene);

/// Returns a text for each obstacle of the scene that describes its first touch in one line. Collective.
/// Throws UserError.
std::vector<std::string> first_touch_lines(const step::Stepper& stepper, const scene::Scene& scene);

} // namespace signorini::trajectory
