// SPDX-License-Identifier: GPL-3.0-or-later
#include "problem/run_objective.h"
#include <array>

namespace signorini::problem {

namespace {

/// Motion under a reference control, computed step by step on demand; steps must be requested in order.
class Marching final : public step::Displacements {
public:
  Marching(const Problem& problem, const control::ControlSpace& controls, const scene::Components& reference)
      : problem_(problem), force_(controls, reference, "objective.desired.control", false),
        load_(problem.load(&force_)), work_(problem.stepper.workspace()),
        contact_{problem.stepper.contact_state(), problem.stepper.contact_state()},
        integrator_(problem.stepper, problem.initial,
                    [this](const step::TimeStep& step, const step::State& from, step::State& to) {
                      problem_.stepper.step({step, from, load_.at(step), contact(step.k - 1)},
                                            {to, contact(step.k)}, work_);
                    }) {
    integrator_.restart();
  }
  [[nodiscard]] Vec y(const step::TimeStep& step) const override {
    const auto timer = problem_.timers.time("desired state");
    if (integrator_.now().k < step.k)
      integrator_.advance(step);
    return integrator_.now().state.y();
  }

private:
  contact::ContactState& contact(int k) const { return contact_[static_cast<std::size_t>(k % 2)]; }

  const Problem& problem_;
  control::SampledForce force_;
  step::ForceAtStep load_;
  // States follow each other: each is computed on demand from the one before, so that two are stored.
  mutable step::Stepper::Workspace work_;
  mutable std::array<contact::ContactState, 2> contact_;
  mutable trajectory::TimeIntegrator integrator_;
};

std::unique_ptr<const step::Displacements> desired(const Problem& problem,
                                                   const control::ControlSpace& controls) {
  if (const auto* reference = std::get_if<scene::DesiredControl>(&problem.scene.objective->desired))
    return std::make_unique<Marching>(problem, controls, reference->control);
  return given_motion(problem, false);
}

} // namespace

RunObjective::RunObjective(const Problem& problem, const GivenControl& given)
    : problem_(problem), given_(given),
      controls_(problem.space, problem.operators, problem.grid, *problem.scene.control),
      observed_(problem.space, problem.operators, problem.scene), desired_(desired(problem, controls_)) {}

void RunObjective::observe(const trajectory::Frame& frame) {
  const auto timer = problem_.timers.time("objective");
  const Vec desired = desired_->y(frame.step); // at every step: it may be computed step by step
  const bool weighs = problem_.scene.objective->tracking > 0 || frame.last;
  squared_distances_.push_back(weighs ? observed_.squared_distance(frame.after.y(), desired) : 0);
}

control::ObjectiveValue RunObjective::value() const {
  const scene::Scene& scene = problem_.scene;
  std::optional<control::ControlSpace> chosen; // on steps that were unknown at first
  if (!controls_.grid().complete())
    chosen.emplace(problem_.space, problem_.operators, problem_.grid, *scene.control);
  const control::ControlSpace& controls = chosen ? *chosen : controls_;
  return control::TimeWeights(*scene.objective, problem_.grid)
      .value(squared_distances_, controls, given_.control(controls));
}

} // namespace signorini::problem
