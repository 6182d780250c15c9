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

/// Contact force on the body in a step, and impulse so far; in 2D forces are N/m, impulses N s/m.
struct ObstacleForce {
  std::array<double, 3> force{};   ///< resultant on the body, N
  double normal_force = 0;         ///< sum of the moduli of the nodal forces, N
  int active = 0;                  ///< candidates in contact
  double min_gap = 0;              ///< the least gap of a candidate, m
  std::array<double, 3> impulse{}; ///< Σ τ_k F_k of the steps so far, N s
};

/// The contact forces of a motion by obstacles, frame by frame. The force of step k, docs/method.md section
/// 2, acts from t_{k−1} to t_k. Not collective: every rank has all candidates.
class ObstacleForces {
public:
  /// `stepper` must outlive this object; without contact there are no obstacles.
  explicit ObstacleForces(const step::Stepper& stepper);

  /// Takes the frame after the last one, from frame 0 on, in which no force acts yet. Allocates at the first.
  void observe(const trajectory::Frame& frame);

  /// Forces of each obstacle, by its number in the scene.
  [[nodiscard]] const std::vector<ObstacleForce>& each() const { return each_; }
  /// Force of all obstacles together.
  [[nodiscard]] const ObstacleForce& all() const { return all_; }

private:
  const step::Stepper& stepper_;
  std::vector<ObstacleForce> each_;
  ObstacleForce all_;
  std::vector<double> forces_; ///< forces of rows, N
};

/// Finds the step of the largest contact force of a motion. If forces differ by rounding alone it is the
/// first of them, which is the same on any number of ranks.
class LargestForce {
public:
  /// Takes the normal force of the next step, N; returns whether it is the largest so far.
  bool observe(double force);

private:
  double largest_ = 0;
};

/// Intervals in which some candidates of a motion are in contact, within steps (docs/method.md section 8).
///
/// Counting steps resolves contact times to τ/2. Here an interval of contact begins where the gaps before it,
/// continued linearly, vanish, and ends where those after it do. With a and b the first and the last step of
/// the interval with a force, and i the candidates that have one there,
///     start = t_{a−1} + min_i τ_{a−1} g_{a−1} / (g_{a−2} − g_{a−1})
///     end   = t_{b+1} − min_i τ_{b+2} g_{b+1} / (g_{b+2} − g_{b+1})
/// within the steps a and b + 1. If the two gaps do not fall towards the contact, or there are no two, it is
/// the middle of that step. With middles throughout the times are those of counting steps. The error is O(τ²)
/// where bodies meet and part with a speed.
class ContactTimes {
public:
  /// `candidates`: numbers of the observed candidates.
  explicit ContactTimes(std::vector<int> candidates) : candidates_(std::move(candidates)) {}

  /// Takes the contact of all candidates after a step, for k = 0, 1, 2 … in turn.
  void observe(const step::TimeStep& step, const contact::ContactState& contact);

  /// An interval of contact, s.
  struct Interval {
    double start, end;
  };
  /// Intervals of the frames observed so far; one that lasts ends with the last of them.
  [[nodiscard]] const std::vector<Interval>& intervals() const { return intervals_; }

private:
  /// Time from the begin of step k to the onset of contact in it, and from the release in step k − 1 to the
  /// end of that step, s.
  [[nodiscard]] double until_onset(const std::vector<int>& touching) const;
  [[nodiscard]] double since_release() const;

  std::vector<int> candidates_;
  std::vector<double> before_, last_, now_; ///< gaps after steps k − 2, k − 1 and k
  std::vector<int> touching_;               ///< indices in candidates_ of those in contact in step k
  std::vector<int> held_;                   ///< indices of those in the last step of the last interval
  std::vector<Interval> intervals_;
  step::TimeStep step_, step_before_; ///< steps k and k − 1
  bool ending_ =
      false; ///< step k is the first without contact: the gap after the next one determines the end
};

/// Suffix of the names that belong to one of several obstacles of a scene, by its index.
std::string obstacle_suffix(int obstacle);

/// Measures impulse, forces and times of contact frame by frame: of all obstacles together and, where there
/// are several, of each, with its number at the end of the names. In the plane forces are per metre.
class ContactFigures {
public:
  /// `stepper` must outlive this object.
  explicit ContactFigures(const step::Stepper& stepper);

  /// Takes the frames of a motion in turn.
  void operator()(const trajectory::Frame& frame);

  /// Values by name at the end of a motion that took `end` s; without contact it starts at the end.
  [[nodiscard]] std::map<std::string, double> numbers(double end) const;

private:
  /// Figures of one obstacle, or of all.
  struct ObstacleFigures {
    std::string suffix; ///< suffix of the quantities' names
    ContactTimes times;
    trajectory::ImpulseRecord record{};        ///< record of the sum of the forces' moduli
    std::array<double, 3> before{}, impulse{}; ///< last step's force, N (in 2D N/m); impulse, N s (N s/m)
    double peak = 0;
    /// Takes the force of a step that ends at `t` (s).
    void add(double t, const ObstacleForce& now);
  };

  const step::Stepper& stepper_;
  ObstacleForces forces_;
  std::vector<ObstacleFigures> obstacles_; ///< figures of all obstacles together first
};

} // namespace signorini::diagnostics
