// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/restitution.h"

namespace signorini::accuracy {

Restitution::Restitution(const problem::Problem& problem) : forces_(problem.stepper) {
  if (problem.scene.several_bodies())
    bodies_.emplace(problem.stepper, problem.scene.contacts);
  summary_.emplace(problem.stepper, problem.scene, bodies_ ? &*bodies_ : nullptr);
}

void Restitution::observe(const trajectory::Frame& frame, const diagnostics::StepBalance& balance,
                          const diagnostics::Balance& weigh) {
  forces_.observe(frame);
  if (bodies_)
    bodies_->observe(frame, weigh);
  summary_->observe(frame, balance, forces_);
}

std::optional<double> Restitution::value() const {
  const std::optional<diagnostics::Impact> impact = summary_->impact();
  return impact ? impact->whole.restitution : std::nullopt;
}

} // namespace signorini::accuracy
