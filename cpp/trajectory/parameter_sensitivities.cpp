// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/parameter_sensitivities.h"
#include <algorithm>

namespace signorini::trajectory {
using petsc::check;

ParameterSensitivities::ParameterSensitivities(const step::Stepper& stepper, step::ParameterRates& rates)
    : stepper_(stepper), rates_(rates), work_(stepper.workspace()), from_(stepper.state()),
      source_(stepper.space().vector()), force_(stepper.space().vector()), normal_(stepper.rows()),
      law_(normal_.size()), predictor_normal_(normal_.size()), zeta_(normal_.size()) {
  for (std::size_t j = 0; j < rates.count(); ++j)
    motions_.push_back({stepper.state(), std::vector<double>(normal_.size())});
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
  const step::Scheme scheme = frame.step.scheme();
  for (std::size_t j = 0; j < motions_.size(); ++j) {
    Derivative& now = motions_[j];
    from_.copy(now.state);
    check(VecZeroEntries(source_));
    rates_.add_step_source(j, source_);
    check(VecScale(source_, 1 / scheme.impulse())); // as a nodal force
    std::ranges::fill(normal_, 0);
    rates_.constraint(j, normal_);
    const bool of_law = rates_.law(j, law_);
    const bool projected = rates_.predictor(j, force_, predictor_normal_);
    const step::PredictorProjection::Data data{force_, predictor_normal_, zeta_};
    stepper_.linearised_step({frame.step.scheme(),
                              from_,
                              {{.vector = source_}},
                              now.state,
                              normal_,
                              now.lambda,
                              of_law ? std::span<const double>(law_) : std::span<const double>(),
                              projected ? &data : nullptr},
                             frame.contact, work_);
    rates_.add_branch_source(j, now.state);
  }
}

} // namespace signorini::trajectory
