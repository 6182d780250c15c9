#pragma once

namespace signorini::forward {

/// The coefficients of one Newmark step of length τ, (4.21)–(4.22), docs/method.md section 2. With the
/// predictor x = y_{k−1} + τ v_{k−1} and its jump j = Πx − x, zero except in contact-stabilized stepping, a
/// step is
///     D y_k + N λ_k = R y_{k−1} + momentum() M (v_{k−1} + jump_rate() j) + impulse() (f_k + s W u_k)
///     v_k = rate() (y_k − y_{k−1} − j) − v_{k−1},   R = D − 2 stiffness() A
/// and its transpose, with j = Π_{k+1} q_{k+1} − q_{k+1},
///     D p_k − μ_k = R p_{k+1} − momentum() M (q_{k+1} + dual_jump() j) + ∂J/∂y_k
///     q_k = −q_{k+1} + rate() (p_{k+1} − p_k) + dual_velocity_jump() j
/// Defined only here, except that the form d in forms/, which defines D, holds stiffness() and τ/2 too.
struct Scheme {
  double tau; ///< length of the step, s

  [[nodiscard]] double momentum() const { return tau; }
  [[nodiscard]] double impulse() const { return tau * tau / 2; }
  [[nodiscard]] double rate() const { return 2 / tau; }
  [[nodiscard]] double stiffness() const { return tau * tau / 4; }
  [[nodiscard]] double jump_rate() const { return 1 / tau; }
  [[nodiscard]] static double dual_jump() { return 1.5; }
  [[nodiscard]] static double dual_velocity_jump() { return -2; }
};

/// The times of the steps: t_0 = 0, t_k = t_{k−1} + τ_k. All lengths are equal.
struct TimeGrid {
  double tau; ///< s

  [[nodiscard]] double time(int k) const { return k * tau; }
  /// τ_k.
  [[nodiscard]] double length(int) const { return tau; }
  [[nodiscard]] Scheme scheme(int k) const { return {length(k)}; }
  /// Loads and control are constant on (t_{k−1}, t_k); the load is the one at its middle.
  [[nodiscard]] double load_time(int k) const { return (k - 0.5) * tau; }
};

} // namespace signorini::forward
