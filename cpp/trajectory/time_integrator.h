// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "step/load.h"
#include "step/step.h"
#include <array>
#include <functional>

namespace signorini::trajectory {

/// Extrapolates a series of solutions by the parabola through the last three, as a guess of the next one.
/// Does nothing where the stepper's solver takes no guess.
class Extrapolation {
public:
  explicit Extrapolation(const step::Stepper& stepper);

  /// Stores a copy of the latest solution, of time `t` (s), unless it is known already.
  void remember(double t, Vec x);
  /// Sets `out` to the extrapolated solution of time `t`; leaves it unchanged if nothing is stored.
  void guess(double t, Vec out) const;

  void forget() { known_ = 0; }
  /// Copies the solutions of `other`.
  void take(const Extrapolation& other);

  /// Number of vectors that an object stores.
  static int vectors(const step::Stepper& stepper) { return stepper.solver().takes_guess() ? most : 0; }

private:
  static constexpr int most = 3;
  bool wanted_;
  std::array<petsc::Vector, most> last_; ///< the latest first
  std::array<double, most> times_{};     ///< times of these, s
  int known_ = 0;
};

/// Data that the steps after t_k depend on, except for the contact of step k. Steps from a copy give the same
/// bits.
struct Checkpoint {
  int k = 0;
  step::State state;
  Extrapolation guesses; ///< extrapolation of the states up to here

  /// Collective.
  explicit Checkpoint(const step::Stepper& stepper);
  /// Copies `other`.
  void take(const Checkpoint& other);

  /// Memory on all ranks, bytes.
  static double bytes(const step::Stepper& stepper);
};

/// Integrates in time, y_0 … y_N, one step at a time. All members collective.
class TimeIntegrator {
public:
  /// Makes a step; to.y() holds a guess on entry.
  using Step = std::function<void(const step::TimeStep& step, const step::State& from, step::State& to)>;

  /// `start` is the state at t_0. All must outlive this object.
  TimeIntegrator(const step::Stepper& stepper, const step::State& start, Step step);

  /// Returns to t_0.
  void restart();
  /// Continues from a checkpoint.
  void resume(const Checkpoint& from);
  /// Makes a step, the one after that to the current state. Throws SolverFailure naming it, after which only
  /// restart() and resume() may be called.
  void advance(const step::TimeStep& step);
  /// Undoes the last step, once.
  void take_back();

  /// The current step and state; k < 0 before the first restart() or resume() and after a failed step.
  [[nodiscard]] const Checkpoint& now() const { return now_; }
  /// The state before the last step; valid until the next.
  [[nodiscard]] const step::State& before() const { return before_; }

private:
  const step::State& start_;
  Step step_;
  Checkpoint now_;
  step::State before_;
};

/// Interpolates the scene's initial fields and moves nodes out of obstacles if the scene asks for it. A field
/// that is not given is zero, except on moving clamps, which prescribe it. Collective. Throws UserError if a
/// field differs from the clamps' motion at t = 0 or a candidate starts inside an obstacle.
[[nodiscard]] step::State initial_state(const step::Stepper& stepper, const scene::Initial& scene);

/// State of a motion at t_k, with the step k that led to it. Frame 0 is the initial state: it has no
/// step, and the vectors of one are null. Valid only during the call of the observer.
struct Frame {
  step::TimeStep step;
  const step::State* before; ///< at t_{k−1}, null in frame 0
  step::NodalForce load;     ///< f_k + s u_k
  const step::State& after;  ///< at t_k
  const contact::ContactState& contact;
  bool last; ///< no other frame follows

  /// The sum of the moduli of the normal forces of the candidates in the step, N.
  [[nodiscard]] double normal_force() const {
    double sum = 0;
    for (const double lambda : contact.normal_lambda())
      sum += lambda / step.scheme().impulse();
    return sum;
  }
};

using StepObserver = std::function<void(const Frame&)>;

/// Whether a request to stop ends a motion.
enum class Stops { obeyed, ignored };

/// Makes the steps of `grid` from the initial state and passes each frame to `watch`,
/// storing no more than the last two states; ends early if a stop was requested and is obeyed. Returns the
/// number of steps done. Collective. Throws SolverFailure naming the step.
int integrate(const step::Stepper& stepper, const step::TimeGrid& grid, const step::State& initial,
              const step::ForceAtStep& load, const StepObserver& watch, Stops stops = Stops::obeyed);

class StepControl;

/// Integrates to the end of the motion with steps whose lengths `control` chooses; returns these, which are
/// incomplete if a stop was requested. `watch` (which may be empty) is called for accepted steps only.
/// Collective. Throws SolverFailure naming the step.
[[nodiscard]] step::TimeGrid integrate_choosing(const step::Stepper& stepper, const step::State& initial,
                                                const step::ForceAtStep& load, StepControl& control,
                                                const StepObserver& watch);

/// Makes the steps of `grid` by `integrator` from t_0 on, as integrate() does. `acting` and `contact(k)`
/// refer to the load and the contact of the integrator's last step.
int integrate_with(const step::Stepper& stepper, const step::TimeGrid& grid, TimeIntegrator& integrator,
                   Stops stops, const std::function<contact::ContactState&(int k)>& contact,
                   const step::NodalForce& acting, const StepObserver& watch);

/// The number of candidates of a run, 0 without contact.
inline int candidates(const step::Stepper& stepper) { return stepper.pairs() ? stepper.pairs()->count() : 0; }

} // namespace signorini::trajectory
