// SPDX-License-Identifier: GPL-3.0-or-later
#include "problem/motion_block.h"
#include <algorithm>

namespace signorini::problem {

MotionBlock::MotionBlock(const Problem& problem, ControlProblem& control_problem)
    : problem_(problem), control_problem_(control_problem) {
  // Desired states that are recomputed from checkpoints belong to one motion at a time.
  const scene::Scene& scene = problem.scene;
  const bool recomputes = scene.trajectory.storage == scene::Storage::checkpoints &&
                          std::holds_alternative<scene::DesiredControl>(scene.objective->desired);
  unites_ = !control_problem.scenarios && !recomputes && problem.grid.equal() &&
            problem.stepper.unite(problem.stepper.first_length(), nullptr);
}

void MotionBlock::run(std::span<const control::Control> controls,
                      const std::function<void(std::size_t i, control::ReducedProblem& reduced)>& compute) {
  if (!unites_) {
    for (std::size_t i = 0; i < controls.size(); ++i)
      compute(i, control_problem_.reduced);
    return;
  }
  if (!motions_)
    motions_.emplace(problem_, control_problem_.controls, control_problem_.objective);
  for (std::size_t first = 0; first < controls.size(); first += largest) {
    const std::size_t count = std::min(largest, controls.size() - first);
    while (motions_->size() < count)
      motions_->add(problem_.scene, largest);
    std::vector<std::function<void()>> tasks;
    for (std::size_t i = 0; i < count; ++i)
      tasks.emplace_back([&, i] { compute(first + i, (*motions_)[i]); });
    motions_->run(tasks);
  }
}

} // namespace signorini::problem
