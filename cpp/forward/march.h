#pragma once
#include "forward/extrapolation.h"
#include <functional>

namespace signorini::forward {

/// A motion at t_k, or a linearised one: all that the next steps start from, but for the contact of the last
/// one, so that they are the same to the last bit from a copy.
struct State {
  int k = 0;
  petsc::Vector y, v;    ///< displacement (m) and velocity (m/s)
  Extrapolation guesses; ///< from the states before

  /// Collective.
  explicit State(const Stepper& stepper);
  void take(const State& other);

  /// Memory on all ranks, bytes.
  static double bytes(const Stepper& stepper);
};

/// step ∘ … ∘ step, one at a time. All members collective.
class March {
public:
  /// From (y0, v0) to (y1, v1) by step k; y1 holds a guess on entry.
  using Step = std::function<void(int k, Vec y0, Vec v0, Vec y1, Vec v1)>;

  /// `y` and `v` are the state at t_0. All must outlive this object.
  March(const Stepper& stepper, Vec y, Vec v, Step step);

  /// To t_0.
  void restart();
  void resume(const State& state);
  /// By one step. Throws SolverFailure naming it, after which only restart() and resume() go on.
  void advance();

  /// Where it is; k < 0 if nowhere.
  [[nodiscard]] const State& state() const { return state_; }
  /// Before the last step; valid until the next.
  [[nodiscard]] Vec y0() const { return y0_; }
  [[nodiscard]] Vec v0() const { return v0_; }

private:
  const Stepper& stepper_;
  Vec y_start_, v_start_;
  Step step_;
  State state_;
  petsc::Vector y0_, v0_;
};

} // namespace signorini::forward
