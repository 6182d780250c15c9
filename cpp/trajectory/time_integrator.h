// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "step/load.h"
#include "step/step.h"
#include "trajectory/extrapolation.h"
#include <functional>

namespace signorini::trajectory {

/// State of an integration at t_k: the data on which later steps depend, except for the contact of step k.
/// Steps made from a copy give the same states to the last bit.
struct Checkpoint {
  int k = 0;
  step::State state;
  Extrapolation guesses; ///< extrapolation of the displacements up to t_k

  /// Creates a checkpoint with a zero state. Collective.
  explicit Checkpoint(const step::Stepper& stepper);
  /// Copies step, state and extrapolation from `other`.
  void take(const Checkpoint& other);

  /// Returns the memory of a checkpoint on all ranks, bytes.
  static double bytes(const step::Stepper& stepper);
};

/// Integrates a motion y_0 … y_N one step at a time. All members are collective.
class TimeIntegrator {
public:
  /// Function that makes `step` from the state `from` to the state `to`; to.y() holds a guess on entry.
  using Step = std::function<void(const step::TimeStep& step, const step::State& from, step::State& to)>;

  /// `start`: state at t_0; `step`: makes a step. The references must outlive this object.
  TimeIntegrator(const step::Stepper& stepper, const step::State& start, Step step);

  /// Returns to the state at t_0.
  void restart();
  /// Continues from a copy of a checkpoint.
  void resume(const Checkpoint& from);
  /// Makes `step`, which must begin at the current time. Throws SolverFailure naming the step, after which
  /// only restart() and resume() may be called.
  void advance(const step::TimeStep& step);
  /// Undoes the last step. Earlier steps cannot be undone.
  void take_back();

  /// Returns the current step number and state; k < 0 before the first restart() or resume() and after a
  /// failed step.
  [[nodiscard]] const Checkpoint& now() const { return now_; }
  /// Returns the state before the last step; valid until the next step.
  [[nodiscard]] const step::State& before() const { return before_; }

private:
  const step::State& start_;
  Step step_;
  Checkpoint now_;
  step::State before_;
};

/// Returns the state at t_0 from the scene's initial fields, with the body dropped or nodes moved out of
/// obstacles if the scene asks for it. A field that is not given is zero, except for the values that moving
/// clamps prescribe. Collective. Throws UserError if a field differs from the clamps' motion at t = 0 or a
/// candidate starts inside an obstacle.
[[nodiscard]] step::State initial_state(const step::Stepper& stepper, const scene::Scene& scene);

/// One step of a motion as observers receive it: step k and the states around it. In frame 0, the initial
/// state, there is no step, and `before` and the vectors of `load` are null. Valid only during the observer's
/// call.
struct Frame {
  step::TimeStep step;
  const step::State* before; ///< state at t_{k−1}, null in frame 0
  step::NodalForce load;     ///< force f_k + s u_k in step k
  const step::State& after;  ///< state at t_k
  const contact::ContactState& contact;
  bool last; ///< whether this is the last frame

  /// Returns the sum of the candidates' normal forces in the step, N (in plane strain and plane stress N/m).
  [[nodiscard]] double normal_force() const {
    double sum = 0;
    for (const double lambda : contact.normal_lambda())
      sum += lambda / step.scheme().impulse();
    return sum;
  }
};

using StepObserver = std::function<void(const Frame&)>;

/// Selects whether a request to stop ends a motion early.
enum class Stops { obeyed, ignored };

/// Makes the steps of `grid` from the state `initial` under `load` and passes each frame to `watch`. Stores
/// only the last two states. Ends early if a stop was requested and `stops` is obeyed, and with the step
/// after those for which `ended`, unless null, returns true. Returns the number of steps made. Collective.
/// Throws SolverFailure naming the step.
int integrate(const step::Stepper& stepper, const step::TimeGrid& grid, const step::State& initial,
              const step::ForceAtStep& load, const StepObserver& watch, Stops stops = Stops::obeyed,
              const std::function<bool()>& ended = {});

class StepControl;

/// Integrates to the end of the motion with steps whose lengths `control` chooses. Returns the grid of these
/// steps, which is incomplete if a stop was requested. `watch`, which may be empty, receives frame 0 and the
/// accepted steps. Collective. Throws SolverFailure naming the step.
[[nodiscard]] step::TimeGrid integrate_choosing(const step::Stepper& stepper, const step::State& initial,
                                                const step::ForceAtStep& load, StepControl& control,
                                                const StepObserver& watch);

/// Makes the steps of `grid` with `integrator` from t_0 on, as integrate() does, and passes frames to
/// `watch`. `contact(k)`: returns the contact of step k; `acting`: force of the step made last. Returns the
/// number of steps made.
int integrate_with(const step::Stepper& stepper, const step::TimeGrid& grid, TimeIntegrator& integrator,
                   Stops stops, const std::function<contact::ContactState&(int k)>& contact,
                   const step::NodalForce& acting, const StepObserver& watch,
                   const std::function<bool()>& ended = {});

/// Returns the number of candidates of a run, 0 without contact.
inline int candidates(const step::Stepper& stepper) { return stepper.pairs() ? stepper.pairs()->count() : 0; }

} // namespace signorini::trajectory
