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

/// Fills `trajectory` from the initial state, step ∘ … ∘ step. `load` acts in each step; `after_step(k)` is
/// told of each. Stops early, with trajectory.steps < N, if a stop was requested. Collective. Throws
/// SolverFailure naming the step.
void simulate(const Stepper& stepper, const Initial& initial, const Load& load, Trajectory& trajectory,
              const std::function<void(int k)>& after_step = {});

} // namespace signorini::forward
