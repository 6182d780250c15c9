// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "step/step.h"
#include <array>
#include <functional>

namespace signorini::trajectory {

/// Extrapolates a series of solutions by the parabola through the last three, as a guess of the next one;
/// does nothing where the stepper's solver takes no guess.
class Extrapolation {
public:
  explicit Extrapolation(const step::Stepper& stepper);

  /// Stores a copy of the latest solution, of time `t` (s), unless it is known already.
  void remember(double t, Vec x);
  /// Sets `out` to the extrapolated solution of time `t`; leaves it unchanged if nothing is remembered.
  void guess(double t, Vec out) const;

  void forget() { known_ = 0; }
  /// Copies what `other` remembers.
  void take(const Extrapolation& other);

  /// Number of vectors that an object stores.
  static int vectors(const step::Stepper& stepper) { return stepper.solver().takes_guess() ? most : 0; }

private:
  static constexpr int most = 3;
  bool wanted_;
  std::array<petsc::Vector, most> last_; ///< the latest first
  std::array<double, most> times_{};     ///< of these
  int known_ = 0;
};

/// What the steps after t_k depend on, except for the contact of step k, so that steps from a copy give the
/// same bits.
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
  /// Takes the last step back, once.
  void take_back();

  /// Where it is; k < 0 before the first restart() or resume() and after a failed step.
  [[nodiscard]] const Checkpoint& now() const { return now_; }
  /// The state before the last step; valid until the next.
  [[nodiscard]] const step::State& before() const { return before_; }

private:
  const step::State& start_;
  Step step_;
  Checkpoint now_;
  step::State before_;
};

} // namespace signorini::trajectory
