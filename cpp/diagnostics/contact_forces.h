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

/// Contact force of one obstacle, or of all, on the body in a step, and the impulse so far. In 2D forces are
/// in N/m, impulses in N s/m.
struct ObstacleForce {
  std::array<double, 3> force{};   ///< resultant force on the body, N
  double normal_force = 0;         ///< sum of the moduli of the nodal forces, N
  int active = 0;                  ///< number of candidates in contact
  double min_gap = 0;              ///< least gap of a candidate, m
  std::array<double, 3> impulse{}; ///< Σ τ_k F_k of the steps so far, N s
};

/// Computes the contact forces of a motion by obstacles, frame by frame. The force of step k (docs/method.md
/// section 2) acts from t_{k−1} to t_k. Not collective: every rank has all candidates.
class ObstacleForces {
public:
  /// Creates zero forces for the obstacles of `stepper`, none without contact. `stepper` must outlive this
  /// object.
  explicit ObstacleForces(const step::Stepper& stepper);

  /// Computes the forces of the next frame; frames are passed in order, from frame 0 on, in which no force
  /// acts. Allocates in the first call.
  void observe(const trajectory::Frame& frame);

  /// Returns the forces of each obstacle, by its index in the scene.
  [[nodiscard]] const std::vector<ObstacleForce>& each() const { return each_; }
  /// Returns the force of all obstacles together.
  [[nodiscard]] const ObstacleForce& all() const { return all_; }

private:
  const step::Stepper& stepper_;
  std::vector<ObstacleForce> each_;
  ObstacleForce all_;
  std::vector<double> forces_; ///< forces of the constraint rows, N
};

/// Finds the step of the largest contact force of a motion. Of forces that differ by rounding alone it takes
/// the first one, which is the same on any number of ranks.
class LargestForce {
public:
  /// Takes the normal force of the next step, N; returns whether this is the largest force so far.
  bool observe(double force);

private:
  double largest_ = 0;
};

/// Intervals of time in which any of some candidates is in contact, resolved within steps (docs/method.md
/// section 8).
///
/// Counting steps resolves contact times to τ/2. Here contact begins where the gaps before the interval,
/// continued linearly, vanish, and ends where the gaps after it do. Let a and b be the first and the last
/// step of the interval with a force, and i the candidates that have a force in step a or b, respectively:
///     start = t_{a−1} + min_i τ_{a−1} g_{a−1} / (g_{a−2} − g_{a−1})
///     end   = t_{b+1} − min_i τ_{b+2} g_{b+1} / (g_{b+2} − g_{b+1})
/// within the steps a and b + 1. If two gaps do not exist or do not fall towards the contact, the middle of
/// step a or b + 1 is taken. With middles throughout, the times are those of counting steps. The error is
/// O(τ²) where bodies meet and part with a speed.
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
  std::vector<int> held_; ///< indices of the candidates in contact in the last interval's last step
  std::vector<Interval> intervals_;
  step::TimeStep step_, step_before_; ///< steps k and k − 1
  bool ending_ =
      false; ///< step k is the first without contact: the gap after the next one determines the end
};

/// Returns the suffix of the names of an obstacle's quantities in a scene with several obstacles, from the
/// obstacle's index.
std::string obstacle_suffix(int obstacle);

/// Measures impulse, forces and times of contact frame by frame: of all obstacles together and, if there are
/// several, of each obstacle, whose number is then appended to the names. In the plane forces are per metre.
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
    trajectory::ImpulseRecord record{}; ///< record of the sum of the forces' moduli
    /// Force of the last step, N (in 2D N/m), and impulse so far, N s (N s/m).
    std::array<double, 3> before{}, impulse{};
    double peak = 0;
    /// Takes the force of a step that ends at `t` (s).
    void add(double t, const ObstacleForce& now);
  };

  const step::Stepper& stepper_;
  ObstacleForces forces_;
  std::vector<ObstacleFigures> obstacles_; ///< figures of all obstacles together first
};

} // namespace signorini::diagnostics
