#pragma once

namespace signorini::forward {

/// The coefficients of contact-implicit Newmark stepping (4.21)–(4.22), docs/method.md section 2:
///     D y_k + N λ_k = R y_{k−1} + momentum() M v_{k−1} + impulse() (f_k + s W u_k)
///     v_k = rate() (y_k − y_{k−1}) − v_{k−1},   R = D − 2 stiffness() A
/// Defined only here, except that the form d in forms/, which defines D, holds stiffness() and τ/2 too.
struct Scheme {
  double tau; ///< time step, s

  [[nodiscard]] double momentum() const { return tau; }
  [[nodiscard]] double impulse() const { return tau * tau / 2; }
  [[nodiscard]] double rate() const { return 2 / tau; }
  [[nodiscard]] double stiffness() const { return tau * tau / 4; }
  /// Loads and control are constant on (t_{k−1}, t_k); the load is the one at its middle.
  [[nodiscard]] double load_time(int k) const { return (k - 0.5) * tau; }
  [[nodiscard]] double time(int k) const { return k * tau; }
};

} // namespace signorini::forward
