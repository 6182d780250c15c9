// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/timers.h"
#include "scene/scene.h"
#include "trajectory/time_integrator.h"
#include <limits>
#include <memory>
#include <vector>

namespace signorini::trajectory {

/// Stores the states of N steps as they are computed and returns them later, mostly from the last one to the
/// first. All members collective.
class StateStore {
public:
  virtual ~StateStore() = default;
  /// Stores the states in order, k = 0 … N; k = 0 starts a new motion. Throws WriteFailure.
  virtual void keep(const Checkpoint& now) = 0;
  /// The state at t_k, bit for bit, with its first part alone unless whole states are stored. Valid until
  /// the next call. Throws WriteFailure, SolverFailure.
  virtual const step::State& at(int k) = 0;
};

/// Makes the stores for the states of a run's motions, as the scene's [trajectory] says: in memory, in files
/// on disk, or as a few checkpoints in memory from which the other states are recomputed.
class StateStoreFactory {
public:
  /// `share` is the part of the scene's budget that these stores may use. Checkpoints belong to the store
  /// that was used last; those of the others are discarded. The references must outlive this object. Throws
  /// UserError if there is no room for one checkpoint.
  StateStoreFactory(const step::Stepper& stepper, const step::TimeGrid& grid, const scene::Trajectory& scene,
                    double share, Timers& timers);

  /// Makes a store for the states of the motion of `integrator`, which recomputes those that are not stored.
  /// `whole`: with all parts of the states, else with displacements. This object and the integrator must
  /// outlive it. Collective. Throws WriteFailure.
  [[nodiscard]] std::unique_ptr<StateStore> place(TimeIntegrator& integrator, bool whole = false) const;

  /// The steps of the motions.
  [[nodiscard]] const step::TimeGrid& grid() const { return grid_; }
  [[nodiscard]] bool in_memory() const { return scene_.storage == scene::Storage::memory; }
  /// Memory or disk space on all ranks, bytes: of one motion's store, `whole` as in place(), or of all
  /// checkpoints, which have whole states. Collective.
  [[nodiscard]] double bytes(bool whole = false) const;

private:
  /// The number of parts of a state in a store.
  [[nodiscard]] std::size_t parts(bool whole) const { return whole ? stepper_.state_parts() : 1; }

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

/// Number of steps from the last checkpoint to the next one, for `steps` ≥ 1 from the last checkpoint on and
/// `slots` ≥ 1 still free.
int next_checkpoint(int steps, int slots);

/// Total number of steps, the first run included; the minimum over all choices of checkpoints.
long steps_made(int steps, int slots);

/// Distance of a motion from one with other active sets.
struct Margins {
  double least_force = std::numeric_limits<double>::infinity(),
         largest_force = 0;                             ///< forces of closed candidates, N
  double gap = std::numeric_limits<double>::infinity(); ///< the least gap of open candidates, m

  /// The least force relative to the largest; 0 without any.
  [[nodiscard]] double force() const { return largest_force > 0 ? least_force / largest_force : 0; }
  /// Includes the contact of one more step.
  void take(const contact::ContactState& contact, step::Scheme scheme);
};

/// A stored motion: its states from `storage`, whose grid has its N steps, and the active sets of all steps
/// from memory. All members collective.
class Trajectory final : public step::Displacements {
public:
  /// `whole`: at() returns whole states. The references must outlive this object. Throws WriteFailure.
  Trajectory(const step::Stepper& stepper, const step::State& initial, const StateStoreFactory& storage,
             bool whole = false);
  Trajectory(const Trajectory&) = delete; // its parts refer to it
  Trajectory& operator=(const Trajectory&) = delete;

  /// Integrates the motion under `load` and passes its frames to `watch`; fewer than N steps if a stop was
  /// requested. The terms of `load` must not change while at() is in use, which may recompute states.
  /// Throws SolverFailure naming the step, WriteFailure.
  void run(step::ForceAtStep load, const StepObserver& watch = {});

  [[nodiscard]] const step::TimeGrid& grid() const { return grid_; }
  /// Number of steps of the last run.
  [[nodiscard]] int steps() const { return steps_; }
  /// Active sets of the steps 0…N of the last run; 0 is the initial state, whose candidates count as open.
  [[nodiscard]] const std::vector<contact::ContactLinearisation>& contact() const { return contact_; }
  [[nodiscard]] const Margins& margins() const { return margins_; }
  /// The state at t_k, with y() alone unless `whole`. Valid until the next call of at(). Throws
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
  std::optional<step::ForceAtStep> load_; ///< load of the last run
  step::NodalForce acting_;
  TimeIntegrator integrator_;
  std::unique_ptr<StateStore> states_;
};

} // namespace signorini::trajectory
