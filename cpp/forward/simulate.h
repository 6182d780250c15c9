#pragma once
#include "forward/load.h"
#include "forward/march.h"
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
  NodalForce load; ///< f_k + s u_k
  Vec y1, v1;    ///< at t_k
  const contact::ContactState& contact;
  bool last; ///< no other follows
};

using Watch = std::function<void(const Frame&)>;

/// Whether a request to stop ends a motion.
enum class Stops { obeyed, ignored };

/// Shows `steps` steps from the initial state and keeps none but the last two states; shows fewer if a stop
/// was requested and is obeyed. Returns the number of steps done. Collective. Throws SolverFailure naming the step.
int stream(const Stepper& stepper, const Initial& initial, const ForceAtStep& load, int steps, const Watch& watch,
           Stops stops = Stops::obeyed);

/// Likewise, from t_0 on, what a march makes, whose last step was under the load `acting` and brought the contact
/// `contact(k)`.
int go_through(const Stepper& stepper, March& march, int steps, Stops stops,
               const std::function<contact::ContactState&(int k)>& contact, const NodalForce& acting,
               const Watch& watch);

/// The number of candidates of a run.
inline int candidates(const Stepper& stepper) {
  return stepper.constraints() ? stepper.constraints()->count() : 0;
}

} // namespace signorini::forward
