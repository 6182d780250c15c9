// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/timers.h"
#include "scene/scene.h"
#include "trajectory/time_integrator.h"
#include <limits>
#include <memory>
#include <vector>

namespace signorini::trajectory {

/// Stores the states of a motion of N steps as they are computed, and returns them later, usually from the
/// last to the first. All members are collective.
class StateStore {
public:
  virtual ~StateStore() = default;
  /// Stores the state `now`. States are passed in the order k = 0 … N; k = 0 starts a new motion. Throws
  /// WriteFailure.
  virtual void keep(const Checkpoint& now) = 0;
  /// Returns the state at t_k, equal to the stored one to the last bit. Contains only the displacement unless
  /// the store was created for whole states. Valid until the next call. Throws WriteFailure, SolverFailure.
  virtual const step::State& at(int k) = 0;
};

/// Creates the stores for the states of a run's motions, as the scene's [trajectory] says. They are in
/// memory, in files on disk, or a few checkpoints in memory from which the other states are recomputed.
class StateStoreFactory {
public:
  /// `share`: fraction of the scene's budget that these stores may use. All stores share one pool of
  /// checkpoints. A store that is used takes over the pool, and the checkpoints of the store used before are
  /// discarded. The references must outlive this object. Throws UserError if the budget does not suffice for
  /// one checkpoint.
  StateStoreFactory(const step::Stepper& stepper, const step::TimeGrid& grid, const scene::Trajectory& scene,
                    double share, Timers& timers);

  /// Creates a store for the states of the motion of `integrator`, which recomputes states that are not
  /// stored. `whole_states`: stores whole states, otherwise displacements alone. This object and the
  /// integrator must outlive the store. Collective. Throws WriteFailure.
  [[nodiscard]] std::unique_ptr<StateStore> place(TimeIntegrator& integrator,
                                                  bool whole_states = false) const;

  /// Returns the time grid of the motions.
  [[nodiscard]] const step::TimeGrid& grid() const { return grid_; }
  [[nodiscard]] bool in_memory() const { return scene_.storage == scene::Storage::memory; }
  /// Returns the memory or disk space, on all ranks, that the store of one motion takes, bytes.
  /// `whole_states`: as in place(). With checkpoints, returns the memory of all checkpoints together, which
  /// contain whole states. Collective.
  [[nodiscard]] double bytes(bool whole_states = false) const;

private:
  /// Returns the number of vectors of a stored state.
  [[nodiscard]] std::size_t parts(bool whole_states) const {
    return whole_states ? stepper_.state_parts() : 1;
  }

  struct Pool;
  class InMemory;
  class OnDisk;
  class Checkpoints;

  const step::Stepper& stepper_;
  scene::Trajectory scene_;
  step::TimeGrid grid_;
  Timers& timers_;
  std::shared_ptr<Pool> pool_; ///< null without checkpoints
};

/// Binomial checkpointing (Griewank and Walther 2000, Algorithm 799): the states of a motion of l steps are
/// needed from the last to the first, the first one and s others (slots) can be kept, and the rest are
/// recomputed from the nearest checkpoint before them.

/// Returns the number of steps from the last checkpoint to the next one. `steps` ≥ 1: number of steps from
/// the last checkpoint to the last state that is still needed; `slots` ≥ 1: number of free slots.
int next_checkpoint(int steps, int slots);

/// Returns the number of steps that binomial checkpointing makes in total to reverse a motion of `steps`
/// steps, its first run included. No other choice of checkpoints needs fewer steps.
long steps_made(int steps, int slots);

/// Least contact force and least open gap of a motion. Its active sets remain the same as long as forces and
/// gaps change by less.
struct Margins {
  double least_force = std::numeric_limits<double>::infinity(),
         largest_force = 0;                             ///< least and largest force of closed candidates, N
  double gap = std::numeric_limits<double>::infinity(); ///< least gap of open candidates, m

  /// Returns least_force/largest_force; 0 if there was no force.
  [[nodiscard]] double force() const { return largest_force > 0 ? least_force / largest_force : 0; }
  /// Updates the margins by the contact of one more step.
  void take(const contact::ContactState& contact, step::Scheme scheme);
};

/// A stored motion: integrates it, and returns its states and active sets. The store
/// of the states comes from `storage`, whose time grid defines the N steps; the active sets of all steps are
/// in memory. All members are collective.
class Trajectory final : public step::Displacements {
public:
  /// `initial`: state at t_0; `whole_states`: at() returns whole states, otherwise displacements alone. The
  /// references must outlive this object. Throws WriteFailure.
  Trajectory(const step::Stepper& stepper, const step::State& initial, const StateStoreFactory& storage,
             bool whole_states = false);
  Trajectory(const Trajectory&) = delete; // its members refer to it
  Trajectory& operator=(const Trajectory&) = delete;

  /// Integrates the motion under `load` and passes its frames to `watch`; makes fewer than N steps if a stop
  /// was requested. The terms of `load` must not change while at() is in use, which may recompute states.
  /// Throws SolverFailure naming the step, WriteFailure.
  void run(step::ForceAtStep load, const StepObserver& watch = {});

  [[nodiscard]] const step::TimeGrid& grid() const { return grid_; }
  /// Returns the number of steps made in the last run.
  [[nodiscard]] int steps() const { return steps_; }
  /// Returns the active sets of the steps 0…N of the last run. Entry 0 is the initial state, whose candidates
  /// count as open.
  [[nodiscard]] const std::vector<contact::ContactLinearisation>& contact() const { return contact_; }
  [[nodiscard]] const Margins& margins() const { return margins_; }
  /// Returns the state at t_k; only its displacement unless the trajectory stores whole states. Valid until
  /// the next call of at(). Throws WriteFailure, SolverFailure.
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
  std::optional<step::ForceAtStep> load_; ///< load of the last run
  step::NodalForce acting_;
  TimeIntegrator integrator_;
  std::unique_ptr<StateStore> states_;
};

} // namespace signorini::trajectory
