// SPDX-License-Identifier: GPL-3.0-or-later
#include "step/relaxing_rates.h"

namespace signorini::step {
using petsc::check;

SplitStiffness::SplitStiffness(const fem::Space& space, const std::vector<scene::Material>& materials,
                               std::size_t material) {
  const std::vector<fem::Part> body = fem::parts(space.mesh(), materials);
  const auto [K, G] = materials[material].instantaneous();
  shear = symmetric_half(fem::assemble_elasticity(space, body, material, {.shear = G}));
  bulk = symmetric_half(fem::assemble_elasticity(space, body, material, {.bulk = K}));
}

namespace {

/// Derivative of a branch's gain t/(t + τ/2) by its relaxation time t.
double gain_rate(const Scheme& scheme, double time) {
  const double half = scheme.tau / 2;
  return half / ((time + half) * (time + half));
}

} // namespace

RelaxingRate::RelaxingRate(const fem::Relaxation& relaxation, const scene::Scene& scene,
                           const scene::Unknown& unknown, std::shared_ptr<const SplitStiffness> stiffness)
    : stiffness_(std::move(stiffness)) {
  using enum scene::Parameter;
  const std::size_t number = scene::material_of(scene, unknown);
  const scene::Material& material = scene.materials[number];
  const scene::ElasticModuli long_term = material.long_term(), instantaneous = material.instantaneous();
  const SplitFactors relaxed{long_term.shear / instantaneous.shear, long_term.bulk / instantaneous.bulk};
  if (unknown.of == beta) {
    B_ = relaxed;
    return;
  }
  SplitFactors modulus; // logarithmic derivatives of G_0 and K_0
  const bool long_term_given = material.moduli == scene::Moduli::long_term;
  if (unknown.of == young)
    modulus = {1 / material.young, 1 / material.young};
  else if (unknown.of == poisson)
    modulus = {-1 / (1 + material.poisson), 2 / (1 - 2 * material.poisson)};
  else if (unknown.of == prony_g && long_term_given)
    modulus.shear = 1 / relaxed.shear;
  else if (unknown.of == prony_k && long_term_given)
    modulus.bulk = 1 / relaxed.bulk;
  A_ = {relaxed.shear * modulus.shear - (unknown.of == prony_g ? 1 : 0),
        relaxed.bulk * modulus.bulk - (unknown.of == prony_k ? 1 : 0)};
  const double damping = material.rayleigh.value_or(scene::Rayleigh{}).beta;
  B_ = {damping * A_.shear, damping * A_.bulk};
  const std::size_t unknown_branch =
      scene::of_branch(unknown.of) ? scene::branch_of(scene, unknown) : material.prony.size();
  std::size_t own = 0; // index in material.prony
  for (std::size_t j = 0; j < relaxation.branches().size(); ++j) {
    if (relaxation.branches()[j].material != number)
      continue;
    const scene::Branch& branch = material.prony[own];
    const bool of_unknown = own++ == unknown_branch;
    branches_.push_back({j,
                         {branch.g, branch.k},
                         {branch.g * modulus.shear + (of_unknown && unknown.of == prony_g ? 1 : 0),
                          branch.k * modulus.bulk + (of_unknown && unknown.of == prony_k ? 1 : 0)},
                         branch.time,
                         of_unknown && unknown.of == prony_time});
  }
}

bool RelaxingRate::combine(const Step& step, double SplitFactors::* part, Vec work) const {
  // −τ²/4 A' (y_k + y_{k−1}) − τ/2 B' (y_k − y_{k−1})
  //   − Σ_j (c_j A_j)' (τ²/4 (y_k − y_{k−1}) + τ²/2 q_j,k−1)
  const Scheme& scheme = step.scheme;
  double by_difference = -scheme.tau / 2 * B_.*part;
  check(VecAXPBY(work, -scheme.stiffness() * A_.*part, 0, step.sum));
  bool zero = A_.*part == 0;
  for (const OfBranch& branch : branches_) {
    const double rate = scene::branch_step(scheme.tau, branch.time).gain * branch.rate.*part +
                        (branch.time_unknown ? gain_rate(scheme, branch.time) * branch.value.*part : 0);
    if (rate == 0)
      continue;
    by_difference -= scheme.stiffness() * rate;
    check(VecAXPY(work, -scheme.impulse() * rate, step.from.q()[branch.number]));
    zero = false;
  }
  if (by_difference != 0)
    check(VecAXPY(work, by_difference, step.difference));
  return !zero || by_difference != 0;
}

void RelaxingRate::add_branches(const Step& step, const State& sum) const {
  // decay = 2 gain − 1
  for (const OfBranch& branch : branches_)
    if (branch.time_unknown) {
      const double rate = gain_rate(step.scheme, branch.time);
      check(VecAXPY(sum.q()[branch.number], 2 * rate, step.from.q()[branch.number]));
      check(VecAXPY(sum.q()[branch.number], rate, step.difference));
    }
}

double RelaxingRate::branch_pairing(const Step& step, const petsc::Series& z, Vec change, Vec work) const {
  double sum = 0;
  for (const OfBranch& branch : branches_)
    if (branch.time_unknown) {
      const double rate = gain_rate(step.scheme, branch.time);
      petsc::combine(change, rate, step.difference, 2 * rate, step.from.q()[branch.number]);
      for (const auto& [stiffness, fraction] : {std::pair{Mat(stiffness_->shear), branch.value.shear},
                                                {Mat(stiffness_->bulk), branch.value.bulk}})
        if (fraction != 0) {
          check(MatMult(stiffness, z[branch.number], work));
          sum += fraction * petsc::dot(change, work);
        }
    }
  return sum;
}

} // namespace signorini::step
