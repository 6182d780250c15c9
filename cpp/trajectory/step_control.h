// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "trajectory/approach.h"
#include "trajectory/time_integrator.h"
#include <array>
#include <vector>

namespace signorini::trajectory {

/// Chooses the lengths of steps while a motion is made (docs/method.md section 11). Motions begin, touch and
/// leave in the shortest steps, the floor, which resolve waves in the elements in contact. Longer steps need
/// small estimated errors and agreeing contact forces, and end before the touch that the rigid motion
/// predicts; a step that turns out to be too long is repeated. A length that has not been factorised must
/// save as many steps as its factorisation costs.
class StepControl {
public:
  /// Collective. The references must outlive this object. Throws UserError.
  StepControl(const step::Stepper& stepper, const scene::Scene& scene);

  /// Begins with the state at t_0, before there are steps, under a load. Collective.
  void start(Vec y, Vec v, const step::ForceAtStep& load);
  /// The next step to make: a new one or, after one that was not accepted, a shorter one in its place.
  [[nodiscard]] step::TimeStep next_step() { return steps_.add(level_); }
  /// Whether the step made last is good; if not, it is removed from the grid. Collective, the same on every
  /// rank.
  [[nodiscard]] bool accepts(const Frame& frame);
  /// The accepted steps.
  [[nodiscard]] const step::TimeGridBuilder& steps() const { return steps_; }

  /// Steps that were repeated, so far.
  [[nodiscard]] int rejected() const { return rejected_; }
  [[nodiscard]] const StepErrors& errors() const { return errors_; }

private:
  /// The level by which to repeat a step, its own if it is good.
  [[nodiscard]] int judged(const Frame& frame);
  /// The largest error allowed for a step of a length; infinite where vibration need not be resolved.
  [[nodiscard]] double limit(double tau) const;
  /// Whether the steps ahead need not resolve the body's vibration.
  [[nodiscard]] bool lets_vibration_go() const;
  /// Chooses the level of the next step, at time_, after one of `level`.
  [[nodiscard]] int next(int level);
  /// The longest length to which a run of equal steps may grow, by its errors.
  [[nodiscard]] int grown(int level);
  /// Whether the force must be accurate: it is the chosen quantity, or determines the flight of a free body.
  [[nodiscard]] bool forces_matter() const;
  /// Whether recent means of the force over the windows of longer steps agree with those over window_.
  [[nodiscard]] bool forces_agree(double tau) const;
  /// Time that contact is expected to last from now on: until waves are back, or as long as so far, s.
  [[nodiscard]] double lasts() const;
  /// Level of the longest step within a time, of the floor's length or 16, 256 … times that.
  [[nodiscard]] int longest_within(double time) const;
  /// Returns `level` or, where that would not save its factorisation within the time `ahead` (s) or no step
  /// of its length begins here, a level of shorter steps that is factorised already.
  [[nodiscard]] int worth(int level, double ahead) const;
  /// Stores displacements of a run of equal steps.
  void remember(const Frame& frame);

  const step::Stepper& stepper_;
  scene::StepQuantity quantity_;
  double tolerance_;
  double waves_;  ///< time in which a wave crosses the body twice, s
  double window_; ///< time in which a wave crosses an element in contact, s
  step::TimeGridBuilder steps_;
  int floor_;        ///< level of the shortest steps
  double price_ = 0; ///< cost of a factorisation, steps
  StepErrors errors_;
  Approach approach_;
  const step::ForceAtStep* load_ = nullptr;
  std::vector<bool> used_;      ///< by level; also if discarded since, so that memory has no influence
  std::vector<int> rejections_; ///< number of rejections, by level
  int level_ = 0, rejected_ = 0;
  bool strained_ = true;                       ///< whether the body is, or may be, deformed
  bool let_go_ = false;                        ///< whether vibration of this flight is ignored
  int flight_steps_ = 0;                       ///< steps since contact ended
  double time_ = 0, until_touch_ = 0;          ///< both after the last accepted step, s
  int stored_ = 0;                             ///< number of displacements of the present run of equal steps
  bool fresh_ = false;                         ///< whether the last step stored one
  int least_level_ = 0;                        ///< least level of the grid, after the last accepted step
  std::array<petsc::Vector, 4> displacements_; ///< four steps apart, the latest first
  petsc::Vector difference_;
};

} // namespace signorini::trajectory
