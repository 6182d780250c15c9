#pragma once
#include "forward/load.h"
#include "forward/step.h"
#include "forward/trajectory.h"
#include <functional>

namespace signorini::forward {

/// Initial displacement and velocity.
struct Initial {
  petsc::Vector y, v;

  /// Interpolates the scene's initial fields, zero where it has none but for clamps that move, and moves nodes
  /// out of obstacles if the scene asks for it. Collective. Throws UserError if they differ from what the
  /// clamps do or a candidate starts inside an obstacle.
  Initial(const Stepper& stepper, const scene::Initial& scene);
};

/// A motion at t_k as it goes by, and what brought it there: step k. The initial state is frame 0, which has
/// no step: the vectors of one are null. Valid while it is shown.
struct Frame {
  int k;
  Vec y0, v0;    ///< at t_{k−1}
  StepLoad load; ///< f_k + s u_k
  Vec y1, v1;    ///< at t_k
  const contact::ContactState& contact;
  bool last; ///< no other follows
};

using Watch = std::function<void(const Frame&)>;

/// Shows `steps` steps from the initial state and keeps none but the last two states; shows fewer if a stop
/// was requested. Returns the number of steps done. Collective. Throws SolverFailure naming the step.
int stream(const Stepper& stepper, const Initial& initial, const Load& load, int steps,
           const Watch& watch);

/// Shows the steps that a trajectory holds, with the load that made them. Collective.
void replay(const Stepper& stepper, const Load& load, const Trajectory& trajectory,
            const Watch& watch);

/// Fills `trajectory` from the initial state, step ∘ … ∘ step. `load` acts in each step;
/// `after_step(k)` is told of each. Stops early, with trajectory.steps < N, if a stop was requested.
/// Collective. Throws SolverFailure naming the step.
void simulate(const Stepper& stepper, const Initial& initial, const Load& load, Trajectory& trajectory,
              const std::function<void(int k)>& after_step = {});

} // namespace signorini::forward
