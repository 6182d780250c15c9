// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/parameter_sensitivities.h"
#include "step/united.h"
#include <algorithm>

namespace signorini::trajectory {
using petsc::check;

ParameterSensitivities::Scratch::Scratch(const step::Stepper& stepper)
    : work(stepper.workspace()), from(stepper.state()), source(stepper.space().vector()),
      force(stepper.space().vector()), normal(stepper.rows()), law(normal.size()),
      predictor_normal(normal.size()), zeta(normal.size()) {}

ParameterSensitivities::ParameterSensitivities(const step::Stepper& stepper, step::ParameterRates& rates)
    : stepper_(stepper), rates_(rates) {
  for (std::size_t j = 0; j < rates.count(); ++j)
    motions_.push_back({stepper.state(), std::vector<double>(stepper.rows())});
  const bool together = rates.count() > 1 && stepper.unite(stepper.first_length(), nullptr);
  for (std::size_t j = 0; j < (together ? rates.count() : 1); ++j)
    scratch_.emplace_back(stepper);
}

void ParameterSensitivities::observe(const Frame& frame) {
  if (frame.step.k == 0) {
    for (std::size_t j = 0; j < motions_.size(); ++j) {
      const auto start = [](Vec rate, Vec x) { check(rate ? VecCopy(rate, x) : VecZeroEntries(x)); };
      start(rates_.displacement(j), motions_[j].state.y());
      start(rates_.velocity(j), motions_[j].state.v());
      for (const petsc::Vector& q : motions_[j].state.q())
        check(VecZeroEntries(q));
      std::ranges::fill(motions_[j].lambda, 0);
    }
    return;
  }
  rates_.set({frame.step, *frame.before, frame.after, frame.contact});
  if (scratch_.size() == 1) {
    for (std::size_t j = 0; j < motions_.size(); ++j)
      step(frame, j, scratch_.front());
    return;
  }
  std::vector<std::function<void()>> steps;
  for (std::size_t j = 0; j < motions_.size(); ++j)
    steps.emplace_back([this, &frame, j] { step(frame, j, scratch_[j]); });
  const step::United united(stepper_, frame.step.scheme().tau, lockstep_);
  lockstep_.run(steps);
}

void ParameterSensitivities::step(const Frame& frame, std::size_t j, Scratch& scratch) {
  const step::Scheme scheme = frame.step.scheme();
  Derivative& now = motions_[j];
  scratch.from.copy(now.state);
  check(VecZeroEntries(scratch.source));
  rates_.add_step_source(j, scratch.source);
  check(VecScale(scratch.source, 1 / scheme.impulse())); // as a nodal force
  std::ranges::fill(scratch.normal, 0);
  rates_.constraint(j, scratch.normal);
  const bool of_law = rates_.law(j, scratch.law);
  const bool projected = rates_.predictor(j, scratch.force, scratch.predictor_normal);
  const step::PredictorProjection::Data data{scratch.force, scratch.predictor_normal, scratch.zeta};
  stepper_.linearised_step({scheme,
                            scratch.from,
                            {{.vector = scratch.source}},
                            now.state,
                            scratch.normal,
                            now.lambda,
                            of_law ? std::span<const double>(scratch.law) : std::span<const double>(),
                            projected ? &data : nullptr},
                           frame.contact, scratch.work);
  rates_.add_branch_source(j, now.state);
}

} // namespace signorini::trajectory
