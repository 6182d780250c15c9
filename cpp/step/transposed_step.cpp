// SPDX-License-Identifier: GPL-3.0-or-later
// The transposed linearised step (docs/method.md section 4).
#include "base/timers.h"
#include "step/step.h"

namespace signorini::step {
using petsc::check;

namespace {
long& adjoint_steps = count("adjoint steps");
} // namespace

void Stepper::add_branch_duals(const AdjointStep& step, bool start, Workspace& work) const {
  if (!operators_.relaxation)
    return;
  const fem::Relaxation& relaxation = *operators_.relaxation;
  const Scheme later = step.next->scheme;
  const auto of_later = [&](std::size_t j) {
    return scene::branch_step(later.tau, relaxation.branches()[j].time);
  };
  // c_j z_j,k − c_j' z_j,k+1 with z_j,k = decay_j' z_j,k+1 − impulse() c_j' p_{k+1}, in one product
  for (std::size_t j = 0; j < branches(); ++j) {
    const double time = relaxation.branches()[j].time,
                 gain = start ? 0 : scene::branch_step(step.step.scheme.tau, time).gain;
    work.weights[j] = gain * of_later(j).decay - of_later(j).gain;
    work.weights_p[j] = -gain * later.impulse() * of_later(j).gain;
  }
  relaxation.add({work.weights, step.state.z, work.weights_p, step.state.p_next}, work.r, work.of_branches);
  clamped_.clear(work.r);
  for (std::size_t j = 0; j < branches(); ++j)
    check(
        VecAXPBY(step.state.z[j], -later.impulse() * of_later(j).gain, of_later(j).decay, step.state.p_next));
}

Vec Stepper::transposed_right_hand_side(const AdjointStep& step, double rate, Workspace& work) const {
  if (!step.next) {                                // p_{N+1} and ω_{N+1} are zero
    assemble(step.derivative, operators_, work.r); // (4.40): r = ∂J/∂y_N
    clamped_.clear(work.r);
    return nullptr;
  }
  const Scheme later = step.next->scheme;
  Vec jump = nullptr;
  if (predictor_ && !step.next->contact.predictor.empty()) {
    // j = Π_{k+1} s − s, s = p_{k+1} − 2/τ_{k+1} ω_{k+1}
    check(VecWAXPY(work.work, -later.rate(), step.state.omega, step.state.p_next));
    jump =
        predictor_->linearised_jump(step.next->contact.predictor, work.work, *work.predictor, step.predictor);
  }
  {
    const petsc::ReadArray p(step.state.p_next);
    const petsc::WriteArray omega(step.state.omega), momentum(work.moved);
    const double later_rate = later.rate();
    // ω_k = τ_{k+1} p_{k+1} − ω_{k+1}; momentum: 2/τ_k ω_k − 2/τ_{k+1} ω_{k+1}
    for (std::size_t i = 0; i < omega.size(); ++i) {
      const double before = later.tau * p[i] - omega[i];
      momentum[i] = rate * before - later_rate * omega[i];
      omega[i] = before;
    }
  }
  if (jump) { // ω_k += τ_{k+1} j; momentum += (2/τ_k τ_{k+1} + 1) j
    check(VecAXPY(step.state.omega, later.tau, jump));
    check(VecAXPY(work.moved, rate * later.tau + 1, jump));
  }
  // (4.41): r = R_{k+1} p_{k+1} + M momentum + ∂J/∂y_k
  right_hand_side(of_length(later.tau).R(), step.state.p_next, 1, work.moved, 1, step.derivative, work);
  add_branch_duals(step, rate == 0, work);
  if (step.state.slip)
    check(VecAXPY(work.r, 1, step.state.slip));
  return jump;
}

Vec Stepper::adjoint_step(const AdjointStep& step, Workspace& work) const {
  const Vec jump = transposed_right_hand_side(step, step.step.scheme.rate(), work);
  // D_k p_k + N μ_k = r, p_k·ν_i = 0 for i in A_k
  const std::span<double> mu =
      step.multipliers.empty() && step.state.slip ? std::span<double>(work.mu) : step.multipliers;
  solve_on_active_set(step.step.scheme.tau, Direction::transposed, step.step.contact, step.normal,
                      step.state.p, mu, work, {}, step.law_duals);
  if (step.state.slip)
    set_slip_dual(mu, step.state.slip, work);
  ++adjoint_steps;
  return jump;
}

Vec Stepper::adjoint_start(const AdjointStep& step, Workspace& work) const {
  constexpr double no_step = 0;
  const Vec jump = transposed_right_hand_side(step, no_step, work);
  check(VecCopy(work.r, step.state.p));
  return jump;
}

} // namespace signorini::step
