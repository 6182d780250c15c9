// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace signorini::step {

/// Coefficients of a Newmark step of length τ, (4.21)–(4.22) in docs/method.md section 2. The predictor x =
/// y_{k−1} + τ v_{k−1} has a jump j = Πx − x, zero except in contact-stabilized stepping. A step is
///     D y_k + N λ_k = R y_{k−1} + momentum() M (v_{k−1} + jump_rate() j) + impulse() (f_k + s W u_k)
///     v_k = rate() (y_k − y_{k−1} − j) − v_{k−1},   R = D − 2 stiffness() A
/// The transposed step leads from p_k and the dual M ω_k of v_k to step k − 1, whose rate() and D are rate'
/// and D'. With the jump j = Πs − s of s = p_k − rate() ω_k it is
///     ω_{k−1} = τ (p_k + j) − ω_k
///     D' p_{k−1} + N μ_{k−1} = R p_k + M (rate' ω_{k−1} − rate() ω_k + j) + ∂J/∂y_{k−1}
/// In materials that relax, −impulse() Σ_j gain_j A_j q_j,k−1 is added to the right-hand side, with the gains
/// of scene::branch_step(), which D contains too.
/// These coefficients are defined only here; the form d in forms/, which defines D, repeats stiffness() and
/// τ/2.
struct Scheme {
  double tau; ///< length of the step, s

  [[nodiscard]] double momentum() const { return tau; }
  [[nodiscard]] double impulse() const { return tau * tau / 2; }
  [[nodiscard]] double rate() const { return 2 / tau; }
  [[nodiscard]] double stiffness() const { return tau * tau / 4; }
  [[nodiscard]] double jump_rate() const { return 1 / tau; }
};

} // namespace signorini::step
