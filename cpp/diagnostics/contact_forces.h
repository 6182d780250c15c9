// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/contact_state.h"
#include "step/time_grid.h"
#include "trajectory/impulse_record.h"
#include "trajectory/time_integrator.h"
#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace signorini::diagnostics {

/// Contact force of one obstacle, or of all, on the body in a step, and the impulse so far. In plane
/// strain and plane stress forces are per metre of depth, N/m, and impulses N s/m.
struct ObstacleForce {
  std::array<double, 3> force{};            ///< resultant force on the body, N
  double normal_force = 0;                  ///< sum of the moduli of the nodal forces, N
  int active = 0;                           ///< number of candidates in contact
  double min_gap = 0;                       ///< least gap over the candidates, m
  std::array<double, 3> impulse{};          ///< Σ τ_k F_k of the steps so far, N s
  std::array<double, 3> friction_impulse{}; ///< part of `impulse` by friction
};

/// Computes the contact force of each obstacle on the body, frame by frame. The force of step k
/// (docs/method.md section 2) acts from t_{k−1} to t_k. Not collective: every rank has all candidates.
class ObstacleForces {
public:
  /// Sets the force of each obstacle of `stepper` to zero. each() is empty in a scene without contact.
  /// `stepper` must outlive this object.
  explicit ObstacleForces(const step::Stepper& stepper);

  /// Computes the forces of the next frame. Frames are passed in order, from frame 0 on. In frame 0 no force
  /// acts. The first call allocates memory.
  void observe(const trajectory::Frame& frame);

  /// Returns the forces of each obstacle, by its index in the scene.
  [[nodiscard]] const std::vector<ObstacleForce>& each() const { return each_; }
  /// Returns the force of all obstacles together.
  [[nodiscard]] const ObstacleForce& all() const { return all_; }

private:
  const step::Stepper& stepper_;
  std::vector<ObstacleForce> each_;
  ObstacleForce all_;
  std::vector<double> forces_;   ///< forces of the constraint rows, N
  std::vector<double> friction_; ///< of them those along the surfaces; empty without friction
};

/// Finds the step of the largest contact force of a motion. Among forces that differ by rounding alone it
/// takes the first one, so that the step does not depend on the number of ranks.
class LargestForce {
public:
  /// Takes the normal force of the next step, N; returns whether this is the largest force so far.
  bool observe(double force);

private:
  double largest_ = 0;
};

/// Intervals of time in which at least one of the given candidates is in contact, resolved within steps
/// (docs/method.md section 8).
///
/// Counting steps resolves contact times to τ/2. Here contact begins when the gaps, extrapolated linearly
/// from the two times before the interval, vanish. It ends when the gaps, extrapolated from the two times
/// after the interval, vanish. Let a and b be the first and the last step of the interval with a force. The
/// minimum is over the candidates i that have a force in step a (for start) or in step b (for end):
///     start = t_{a−1} + min_i τ_{a−1} g_{a−1} / (g_{a−2} − g_{a−1})
///     end   = t_{b+1} − min_i τ_{b+2} g_{b+1} / (g_{b+2} − g_{b+1})
/// start is limited to step a, end to step b + 1. If one of the two gaps of a candidate does not exist, or if
/// the gap does not fall towards the contact, the middle of step a or b + 1 is taken. With both middles, an
/// interval of equal steps is as long as its steps with a force. The error is O(τ²) if the body arrives at
/// the obstacle and leaves it at a nonzero speed.
class ContactTimes {
public:
  /// `candidates`: indices of the candidates to observe.
  explicit ContactTimes(std::vector<int> candidates) : candidates_(std::move(candidates)) {}

  /// Takes the contact of all candidates after step k; to be called for k = 0, 1, 2 … in this order.
  void observe(const step::TimeStep& step, const contact::ContactState& contact);

  /// Interval of contact: start and end, s.
  struct Interval {
    double start, end;
  };
  /// Returns the intervals of contact in the steps observed so far. An interval that still lasts ends with
  /// the last of these steps.
  [[nodiscard]] const std::vector<Interval>& intervals() const { return intervals_; }

private:
  /// Returns the time from the begin of step k to the onset of contact in step k, s.
  [[nodiscard]] double until_onset(const std::vector<int>& touching) const;
  /// Returns the time from the release of contact in step k − 1 to the end of that step, s.
  [[nodiscard]] double since_release() const;

  std::vector<int> candidates_;
  std::vector<double> before_, last_, now_; ///< gaps after the steps k − 2, k − 1 and k
  std::vector<int> touching_;               ///< indices in candidates_ of the candidates in contact in step k
  std::vector<int> last_touching_;          ///< like touching_, but for the last step of the latest interval
  std::vector<Interval> intervals_;
  step::TimeStep step_, step_before_; ///< steps k and k − 1
  bool ending_ =
      false; ///< whether step k is the first without contact; the gaps after step k + 1 determine the end
};

/// Returns the suffix _1, _2 … for the obstacle with the index 0, 1 …. In a scene with several obstacles the
/// names of an obstacle's quantities end with this suffix.
std::string obstacle_suffix(int obstacle);

/// Measures impulse, forces and times of contact frame by frame, for all obstacles together. If there are
/// several obstacles, it also measures them for each one, under names that end with obstacle_suffix(). In
/// plane strain and plane stress forces and impulses are per metre of depth.
class ContactFigures {
public:
  /// `stepper` must outlive this object.
  explicit ContactFigures(const step::Stepper& stepper);

  /// Takes the next frame; frames are passed in order, from frame 0 on.
  void operator()(const trajectory::Frame& frame);

  /// Returns the values by name at the end of a motion whose end time is `end` (s); without any contact,
  /// contact_start is `end`.
  [[nodiscard]] std::map<std::string, double> numbers(double end) const;

private:
  /// Quantities of one obstacle, or of all together.
  struct ObstacleFigures {
    std::string suffix; ///< suffix of the quantities' names
    ContactTimes times;
    trajectory::ImpulseRecord record{}; ///< record of the sum of the nodal forces' moduli
    /// Force of the last step and impulse so far, in the units of ObstacleForce.
    std::array<double, 3> before{}, impulse{};
    double peak = 0;
    /// Takes the force of a step that ends at `t` (s).
    void add(double t, const ObstacleForce& now);
  };

  const step::Stepper& stepper_;
  ObstacleForces forces_;
  std::vector<ObstacleFigures> obstacles_; ///< all obstacles together; then each, if there are several
};

} // namespace signorini::diagnostics
