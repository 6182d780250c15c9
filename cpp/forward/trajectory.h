#pragma once
#include "forward/simulate.h"
#include "forward/states.h"
#include <limits>
#include <vector>

namespace signorini::forward {

/// How near a motion is to one with other active sets.
struct Margins {
  double least_force = std::numeric_limits<double>::infinity(), largest_force = 0; ///< λ_i of closed candidates
  double gap = std::numeric_limits<double>::infinity();                            ///< the least of open ones, m

  /// The least force, relative to the largest; 0 without any.
  [[nodiscard]] double force() const { return largest_force > 0 ? least_force / largest_force : 0; }
  void take(const contact::ContactState& contact);
};

/// A motion of N steps that can be looked at again: its states from where the storage keeps them, the active sets
/// of all steps in memory. All members collective.
class Trajectory final : public Displacements {
public:
  /// `velocities`: v() is wanted. The references must outlive this object. Throws WriteFailure.
  Trajectory(const Stepper& stepper, const Initial& initial, int steps, const Storage& storage,
             bool velocities = false);
  Trajectory(const Trajectory&) = delete; // its parts refer to it
  Trajectory& operator=(const Trajectory&) = delete;

  /// Moves the body under `load`, whose terms must stay as they are for as long as states are asked for, and shows the
  /// frames as they go by; fewer than N steps if a stop was requested. Throws SolverFailure naming the step,
  /// WriteFailure.
  void run(ForceAtStep load, const Watch& watch = {});

  /// Those of the last run.
  [[nodiscard]] int steps() const { return steps_; }
  /// Of the steps 0…N; 0 is that of the initial state, whose candidates count as open.
  [[nodiscard]] const std::vector<contact::ContactSets>& contact() const { return contact_; }
  [[nodiscard]] const Margins& margins() const { return margins_; }
  /// Displacement and velocity at t_k. Valid until the next call of at(). Throws WriteFailure, SolverFailure.
  [[nodiscard]] States::View at(int k) const { return states_->at(k); }
  [[nodiscard]] Vec y(int k) const override { return at(k).y; }

private:
  const Stepper& stepper_;
  int capacity_, steps_ = 0;
  std::vector<contact::ContactSets> contact_;
  contact::ContactState now_; ///< of the last step made
  Margins margins_;
  std::optional<ForceAtStep> load_; ///< of the last run
  NodalForce acting_;
  March march_;
  std::unique_ptr<States> states_;
};

} // namespace signorini::forward
