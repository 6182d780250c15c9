#pragma once
#include "base/timers.h"
#include "forward/march.h"
#include "scene/scene.h"
#include <memory>

namespace signorini::forward {

/// The states of a march of N steps, kept as they go by and wanted back, mostly from the last one to the
/// first. All members collective.
class States {
public:
  /// Valid until the next call of the same object.
  struct View {
    Vec y, v; ///< v is null where velocities were not asked for
  };

  virtual ~States() = default;
  /// Takes the states in turn, k = 0 … N; 0 begins afresh. Throws WriteFailure.
  virtual void keep(const State& state) = 0;
  /// The state at t_k, the same to the last bit. Throws WriteFailure, SolverFailure.
  virtual View at(int k) = 0;
};

/// How a run keeps the states of its motions, as the scene's [trajectory] says: in memory, one file a motion
/// on disk, or a few in memory from which the others are made again.
class Storage {
public:
  /// `share` is the part of the scene's budget that this storage may use: its checkpoints are those of
  /// whichever of its motions was used last, and another's are lost to it. The references must outlive this
  /// object. Throws UserError if there is no room for one checkpoint.
  Storage(const Stepper& stepper, const scene::Trajectory& scene, int steps, double share, Timers& timers);

  /// A place for the states of one motion, that of `march`, which goes over it again where they have to be
  /// made again; `velocities`: v is wanted too. This object and the march must outlive it. Collective. Throws
  /// WriteFailure.
  [[nodiscard]] std::unique_ptr<States> place(March& march, bool velocities = false) const;

  [[nodiscard]] bool in_memory() const { return scene_.storage == "memory"; }
  /// On all ranks: of one motion in memory or on disk, or of all checkpoints. Collective.
  [[nodiscard]] double bytes() const;

private:
  struct Pool;
  class InMemory;
  class OnDisk;
  class Checkpoints;

  const Stepper& stepper_;
  scene::Trajectory scene_;
  int steps_;
  Timers& timers_;
  std::shared_ptr<Pool> pool_; ///< null without checkpoints
};

} // namespace signorini::forward
