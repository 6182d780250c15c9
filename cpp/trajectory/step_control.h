// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "trajectory/approach.h"
#include "trajectory/time_integrator.h"
#include <array>
#include <vector>

namespace signorini::trajectory {

/// Chooses step lengths while a motion is integrated (docs/method.md section 11). The motion begins, and
/// contact begins and ends, in the shortest steps (the floor), which resolve waves in elements in contact.
/// Longer steps require small estimated errors and agreement of mean contact forces. They end before the
/// touch that the rigid motion predicts. A step that proves too long is repeated with a shorter one. A new
/// length is factorised only if it saves more steps than the factorisation costs.
class StepControl {
public:
  /// Creates the control for the automatic steps of `scene`. Collective. The references must outlive this
  /// object. Throws UserError.
  StepControl(const step::Stepper& stepper, const scene::Scene& scene);

  /// Starts a motion from its displacement and velocity at t_0, before any step. `load`: force of the steps,
  /// which must outlive the motion. Collective.
  void start(Vec y, Vec v, const step::ForceAtStep& load);
  /// Returns the next step to make: a new step or, after a rejected step, a shorter step in its place.
  [[nodiscard]] step::TimeStep next_step() { return steps_.add(level_); }
  /// Returns whether the step made last is accurate enough; a rejected step is removed from the grid.
  /// Collective, with the same result on every rank.
  [[nodiscard]] bool accepts(const Frame& frame);
  /// Returns the grid of accepted steps.
  [[nodiscard]] const step::TimeGridBuilder& steps() const { return steps_; }

  /// Number of steps rejected so far.
  [[nodiscard]] int rejected() const { return rejected_; }
  [[nodiscard]] const StepErrors& errors() const { return errors_; }

private:
  /// Returns the level (StepLengths) at which the step must be repeated, or its own level if it is accurate
  /// enough.
  [[nodiscard]] int judged(const Frame& frame);
  /// Returns the limit of the estimated error of a step of length `tau` (s), in the unit of
  /// StepErrors::Step::error. Infinite where vibration need not be resolved.
  [[nodiscard]] double limit(double tau) const;
  /// Returns whether the next steps need not resolve the body's vibration.
  [[nodiscard]] bool ignores_vibration() const;
  /// Returns the level of the next step, which begins at time_, after a step of level `level`.
  [[nodiscard]] int next(int level);
  /// Returns the level of the next step after a run of equal steps of level `level`: a lower level, of longer
  /// steps, if estimated errors and contact forces permit it, else `level`.
  [[nodiscard]] int grown_level(int level);
  /// Returns whether contact forces must be accurate: time.quantity requires it, or they determine the flight
  /// of a free body.
  [[nodiscard]] bool forces_matter() const;
  /// Returns whether recent mean contact forces over windows of 8 `tau` agree with means over 2 window_ about
  /// the same times, to half of the tolerance. `tau`: present step length, s.
  [[nodiscard]] bool forces_agree(double tau) const;
  /// Returns the time that contact is expected to last from now on, s: the time until waves return or, if
  /// longer, the time that it has lasted so far.
  [[nodiscard]] double expected_contact_time() const;
  /// Returns the level of the longest step that fits into `time` (s), among lengths of 1, 16, 256, … times
  /// the floor's.
  [[nodiscard]] int longest_within(double time) const;
  /// Returns `level` if a step of this level may begin now, and if the level was used before or its steps
  /// save more than the cost of a factorisation within the time `ahead` (s). Otherwise returns the next
  /// higher level, of shorter steps, that was used before.
  [[nodiscard]] int affordable_level(int level, double ahead) const;
  /// Stores displacements of a run of equal steps, four steps apart.
  void remember(const Frame& frame);

  const step::Stepper& stepper_;
  scene::StepQuantity quantity_;
  double tolerance_;
  double waves_;  ///< time in which a wave crosses the body twice, s
  double window_; ///< time in which a wave crosses an element in contact, s
  step::TimeGridBuilder steps_;
  int floor_;        ///< level of the shortest steps
  double price_ = 0; ///< cost of a factorisation, in steps
  StepErrors errors_;
  Approach approach_;
  const step::ForceAtStep* load_ = nullptr;
  /// Whether each level was used. Levels whose factor was discarded count as used, so that the choice of
  /// lengths does not depend on the memory limit.
  std::vector<bool> used_;
  std::vector<int> rejections_; ///< number of rejections, by level
  int level_ = 0, rejected_ = 0;
  bool strained_ = true;              ///< whether the body is, or may be, deformed
  bool vibration_ignored_ = false;    ///< whether the vibration of the present flight is ignored
  int flight_steps_ = 0;              ///< steps since contact ended
  double time_ = 0, until_touch_ = 0; ///< end of the last accepted step; time from then to the next touch, s
  int stored_ = 0;                    ///< number of displacements stored in the present run of equal steps
  bool fresh_ = false;                ///< whether the last step stored a displacement
  int least_level_ = 0;               ///< TimeGridBuilder::least_level() after the last accepted step
  std::array<petsc::Vector, 4> displacements_; ///< stored displacements, four steps apart, the latest first
  petsc::Vector difference_;
};

} // namespace signorini::trajectory
