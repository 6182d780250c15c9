// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "trajectory/integrate.h"
#include "trajectory/state_store.h"
#include <limits>
#include <vector>

namespace signorini::trajectory {

/// How close a motion is to one with other active sets.
struct Margins {
  double least_force = std::numeric_limits<double>::infinity(),
         largest_force = 0;                             ///< of closed candidates, N
  double gap = std::numeric_limits<double>::infinity(); ///< the least of open candidates, m

  /// The least force relative to the largest; 0 without any.
  [[nodiscard]] double force() const { return largest_force > 0 ? least_force / largest_force : 0; }
  /// Includes the contact of one more step.
  void take(const contact::ContactState& contact, step::Scheme scheme);
};

/// A motion that can be looked up again: its states from `storage`, which names its N steps, the active sets
/// of all steps from memory. All members collective.
class Trajectory final : public step::Displacements {
public:
  /// `whole`: at() returns whole states. The references must outlive this object. Throws WriteFailure.
  Trajectory(const step::Stepper& stepper, const step::State& initial, const StateStoreFactory& storage,
             bool whole = false);
  Trajectory(const Trajectory&) = delete; // its parts refer to it
  Trajectory& operator=(const Trajectory&) = delete;

  /// Integrates the motion under `load` and passes its frames to `watch`; fewer than N steps if a stop was
  /// requested. The terms of `load` must not change for as long as states are asked for, which may be
  /// recomputed. Throws SolverFailure naming the step, WriteFailure.
  void run(step::ForceAtStep load, const StepObserver& watch = {});

  [[nodiscard]] const step::TimeGrid& grid() const { return grid_; }
  /// Number of steps of the last run.
  [[nodiscard]] int steps() const { return steps_; }
  /// Active sets of the steps 0…N of the last run; 0 is the initial state, whose candidates count as open.
  [[nodiscard]] const std::vector<contact::ContactLinearisation>& contact() const { return contact_; }
  [[nodiscard]] const Margins& margins() const { return margins_; }
  /// The state at t_k, of which y() alone without `whole`. Valid until the next call of at(). Throws
  /// WriteFailure, SolverFailure.
  [[nodiscard]] const step::State& at(int k) const { return states_->at(k); }
  [[nodiscard]] Vec y(const step::TimeStep& step) const override { return at(step.k).y(); }

private:
  const step::Stepper& stepper_;
  step::TimeGrid grid_;
  int steps_ = 0;
  std::vector<contact::ContactLinearisation> contact_;
  contact::ContactState now_; ///< contact of the last step made
  step::Stepper::Workspace work_;
  Margins margins_;
  std::optional<step::ForceAtStep> load_; ///< of the last run
  step::NodalForce acting_;
  TimeIntegrator integrator_;
  std::unique_ptr<StateStore> states_;
};

} // namespace signorini::trajectory
