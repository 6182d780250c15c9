// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "step/load.h"
#include "trajectory/time_integrator.h"
#include <functional>

namespace signorini::trajectory {

/// Interpolates the scene's initial fields and moves nodes out of obstacles if the scene asks for it. A field
/// that is not given is zero, except on moving clamps, which prescribe it. Collective. Throws UserError if a
/// field differs from the clamps' motion at t = 0 or a candidate starts inside an obstacle.
[[nodiscard]] step::State initial_state(const step::Stepper& stepper, const scene::Initial& scene);

/// step::State of a motion at t_k, with the step k that led to it. Frame 0 is the initial state: it has no
/// step, and the vectors of one are null. Valid only during the call of the observer.
struct Frame {
  step::TimeStep step;
  const step::State* before; ///< at t_{k−1}, null in frame 0
  step::NodalForce load;     ///< f_k + s u_k
  const step::State& after;  ///< at t_k
  const contact::ContactState& contact;
  bool last; ///< no other frame follows
};

using StepObserver = std::function<void(const Frame&)>;

/// Whether a request to stop ends a motion.
enum class Stops { obeyed, ignored };

/// Makes the steps of `grid` from the initial state and passes each frame to `watch` (which may be empty),
/// storing no more than the last two states; ends early if a stop was requested and is obeyed. Returns the
/// number of steps done. Collective. Throws SolverFailure naming the step.
int integrate(const step::Stepper& stepper, const step::TimeGrid& grid, const step::State& initial,
              const step::ForceAtStep& load, const StepObserver& watch, Stops stops = Stops::obeyed);

class StepControl;

/// Integrates to the end of the motion with steps whose lengths `control` chooses; returns these, which are
/// incomplete if a stop was requested and is obeyed. `watch` sees no step that is repeated. Collective.
/// Throws SolverFailure naming the step.
[[nodiscard]] step::TimeGrid integrate_choosing(const step::Stepper& stepper, const step::State& initial,
                                                const step::ForceAtStep& load, StepControl& control,
                                                const StepObserver& watch, Stops stops = Stops::obeyed);

/// Makes the steps of `grid` by `integrator` from t_0 on, as integrate() does. `acting` and `contact(k)`
/// refer to the load and the contact of the integrator's last step.
int integrate_with(const step::Stepper& stepper, const step::TimeGrid& grid, TimeIntegrator& integrator,
                   Stops stops, const std::function<contact::ContactState&(int k)>& contact,
                   const step::NodalForce& acting, const StepObserver& watch);

/// The number of candidates of a run, 0 without contact.
inline int candidates(const step::Stepper& stepper) { return stepper.pairs() ? stepper.pairs()->count() : 0; }

} // namespace signorini::trajectory
