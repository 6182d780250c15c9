// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "trajectory/extrapolation.h"
#include <functional>

namespace signorini::trajectory {

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
