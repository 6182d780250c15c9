// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/run_objective.h"
#include <array>

namespace signorini {

namespace {

/// The motion under a reference control, made as far as it is asked for; states in ascending order.
class Marching final : public forward::Displacements {
public:
  Marching(const Problem& problem, const control::ControlSpace& controls, const scene::Components& reference)
      : problem_(problem), force_(controls, reference, "objective.desired.control", false),
        load_(problem.load(&force_)), work_(problem.stepper.workspace()),
        contact_{contact::ContactState(forward::candidates(problem.stepper)),
                 contact::ContactState(forward::candidates(problem.stepper))},
        integrator_(problem.stepper, problem.initial.y, problem.initial.v,
                    [this](int k, Vec y0, Vec v0, Vec y1, Vec v1) {
                      problem_.stepper.step({k, {y0, v0}, load_.at(k), contact(k - 1)},
                                            {{y1, v1}, contact(k)}, work_);
                    }) {
    integrator_.restart();
  }
  [[nodiscard]] Vec y(int k) const override {
    const auto timer = problem_.timers.time("desired state");
    while (integrator_.state().k < k)
      integrator_.advance();
    return integrator_.state().y;
  }

private:
  contact::ContactState& contact(int k) const { return contact_[static_cast<std::size_t>(k % 2)]; }

  const Problem& problem_;
  control::SampledForce force_;
  forward::ForceAtStep load_;
  mutable forward::Stepper::Workspace work_;
  mutable std::array<contact::ContactState, 2> contact_;
  mutable forward::TimeIntegrator integrator_;
};

std::unique_ptr<const forward::Displacements> desired(const Problem& problem,
                                                      const control::ControlSpace& controls) {
  if (const auto* reference = std::get_if<scene::DesiredControl>(&problem.scene.objective->desired))
    return std::make_unique<Marching>(problem, controls, reference->control);
  return given_motion(problem, false);
}

} // namespace

RunObjective::RunObjective(const Problem& problem, const GivenControl& given)
    : problem_(problem),
      controls_(problem.space, problem.operators, problem.stepper.grid(), *problem.scene.control),
      given_(given), objective_(controls_, problem.operators, problem.stepper.grid(),
                                desired(problem, controls_), *problem.scene.objective) {}

void RunObjective::observe(const forward::Frame& frame) {
  const auto timer = problem_.timers.time("objective");
  objective_.observe(frame.k, frame.y1, squared_distances_);
}

control::Value RunObjective::value() const {
  const control::Control* given = given_.control();
  return objective_.value(squared_distances_, given ? *given : controls_.zero());
}

} // namespace signorini
