// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "forward/extrapolation.h"
#include <functional>

namespace signorini::forward {

/// State at t_k of a motion or a linearised one: all that the next steps depend on, except for the contact of
/// the last one, so that steps from a copy give the same bits.
struct State {
  int k = 0;
  petsc::Vector y, v;    ///< displacement (m) and velocity (m/s)
  Extrapolation guesses; ///< extrapolation of the states up to here

  /// Collective.
  explicit State(const Stepper& stepper);
  /// Copies `other`.
  void take(const State& other);

  /// Memory on all ranks, bytes.
  static double bytes(const Stepper& stepper);
};

/// Integrates in time, y_0 … y_N, one step at a time. All members collective.
class TimeIntegrator {
public:
  /// Makes a step from (y0, v0) to (y1, v1); y1 holds a guess on entry.
  using Step = std::function<void(const TimeStep& step, Vec y0, Vec v0, Vec y1, Vec v1)>;

  /// `y` and `v` are the state at t_0. All must outlive this object.
  TimeIntegrator(const Stepper& stepper, Vec y, Vec v, Step step);

  /// Returns to t_0.
  void restart();
  /// Continues from `state`.
  void resume(const State& state);
  /// Makes a step, the one after that to the current state. Throws SolverFailure naming it, after which only
  /// restart() and resume() may be called.
  void advance(const TimeStep& step);
  /// Takes the last step back, once.
  void take_back();

  /// The current state; k < 0 before the first restart() or resume() and after a failed step.
  [[nodiscard]] const State& state() const { return state_; }
  /// Displacement and velocity before the last step; valid until the next.
  [[nodiscard]] Vec y0() const { return y0_; }
  [[nodiscard]] Vec v0() const { return v0_; }

private:
  Vec y_start_, v_start_;
  Step step_;
  State state_;
  petsc::Vector y0_, v0_;
};

} // namespace signorini::forward
