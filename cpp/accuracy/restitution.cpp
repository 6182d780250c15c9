// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/restitution.h"

namespace signorini::accuracy {

Restitution::Restitution(const problem::Problem& problem)
    : balance_(problem.stepper, diagnostics::Balance::Wanted{false, false, problem.scene_loads()}),
      forces_(problem.stepper) {
  if (problem.scene.several_bodies())
    bodies_.emplace(problem.stepper, problem.scene.contacts);
  summary_.emplace(problem.stepper, problem.scene, bodies_ ? &*bodies_ : nullptr);
}

void Restitution::observe(const trajectory::Frame& frame) {
  const diagnostics::StepBalance balance = balance_(frame);
  forces_.observe(frame);
  if (bodies_)
    bodies_->observe(frame, balance_);
  summary_->observe(frame, balance, forces_);
}

std::optional<double> Restitution::value() const {
  const std::optional<diagnostics::Impact> impact = summary_->impact();
  return impact ? impact->whole.restitution : std::nullopt;
}

} // namespace signorini::accuracy
