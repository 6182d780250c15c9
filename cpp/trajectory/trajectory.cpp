// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/trajectory.h"
#include <algorithm>

namespace signorini::trajectory {

Trajectory::Trajectory(const step::Stepper& stepper, const step::State& initial,
                       const StateStoreFactory& storage, bool whole)
    : stepper_(stepper), grid_(storage.grid()), contact_(static_cast<std::size_t>(grid_.steps()) + 1),
      now_(stepper.contact_state()), work_(stepper.workspace()),
      integrator_(stepper, initial,
                  [this](const step::TimeStep& step, const step::State& from, step::State& to) {
                    acting_ = load_->at(step);
                    stepper_.step({step, from, acting_, contact_[static_cast<std::size_t>(step.k) - 1]},
                                  {to, now_}, work_);
                  }),
      states_(storage.place(integrator_, whole)) {}

void Margins::take(const contact::ContactState& contact, step::Scheme scheme) {
  for (std::size_t i = 0; i < contact.status.size(); ++i)
    if (contact.status[i] == contact::Status::open) {
      gap = std::min(gap, contact.gap[i]);
    } else {
      const double force = contact.lambda[i] / scheme.impulse();
      least_force = std::min(least_force, force);
      largest_force = std::max(largest_force, force);
    }
}

void Trajectory::run(step::ForceAtStep load, const StepObserver& watch) {
  load_ = std::move(load);
  steps_ = 0;
  now_ = stepper_.contact_state();
  margins_ = {};
  const auto contact = [this](int) -> contact::ContactState& { return now_; };
  integrate_with(stepper_, grid_, integrator_, Stops::obeyed, contact, acting_, [&](const Frame& frame) {
    steps_ = frame.step.k;
    contact_[static_cast<std::size_t>(frame.step.k)] = now_.linearisation();
    if (frame.step.k > 0)
      margins_.take(now_, frame.step.scheme());
    states_->keep(integrator_.now());
    if (watch)
      watch(frame);
  });
}

} // namespace signorini::trajectory
