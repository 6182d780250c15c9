// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/motion_quantities.h"
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace signorini::accuracy {
using petsc::check;

MotionQuantities::MotionQuantities(const problem::Problem& problem, const std::vector<Quantity>& wanted,
                                   const SamplePoints* samples)
    : problem_(problem), wanted_(wanted), warnings_(problem.stepper, problem.scene, problem.scene_loads()),
      contact_(problem.stepper) {
  if (has(wanted, "energy_loss") || has(wanted, of_restitution))
    weigh_.emplace(problem.stepper);
  if (has(wanted, of_restitution))
    restitution_.emplace(problem);
  if (has(wanted, "displacement"))
    displacement_.emplace(*samples, problem.space);
  if (has(wanted, "pressure"))
    pressure_.emplace(problem.space, *problem.stepper.pairs(), problem.scene.contacts);
  if (has(wanted, of_stress)) {
    const std::vector<fem::Part> parts = fem::parts(problem.mesh, problem.scene.materials);
    fields_.emplace(problem.space, parts);
    stress_.emplace(problem.space, parts);
  }
}

void MotionQuantities::operator()(const trajectory::Frame& frame) {
  warnings_.observe(frame);
  const double tau = frame.step.tau, t = frame.step.end;
  if (weigh_) {
    const diagnostics::StepBalance balance = (*weigh_)(frame);
    energy_ = std::max(energy_, balance.energy());
    contact_loss_ -= balance.contact_work - balance.friction_work - balance.belt_work;
    if (restitution_)
      restitution_->observe(frame, balance, *weigh_);
  }
  contact_(frame);
  if (displacement_)
    displacement_->take_until(t, frame.last, [&](double at, Vec y) {
      // Within a step y is quadratic and v linear, except for the jump of a projected predictor.
      const double s = frame.step.k == 0 ? 1 : 1 + (at - t) / tau;
      check(VecCopy(frame.after.y(), y));
      if (frame.step.k > 0 && s < 1) {
        check(VecAXPBY(y, 1 - s, s, frame.before->y()));
        check(VecAXPY(y, -tau / 2 * s * (1 - s), frame.after.v()));
        check(VecAXPY(y, tau / 2 * s * (1 - s), frame.before->v()));
      }
    });
  if (stress_) {
    fields_->set(frame.after.y(), frame.after.v(), frame.after.q());
    stress_->observe(*fields_, frame.after, t);
  }
  if (pressure_ && frame.step.k > 0) {
    constexpr std::size_t kept = 2;
    if (last_forces_.size() == kept)
      last_forces_.erase(last_forces_.begin());
    const std::span<const double> lambda = frame.contact.normal_lambda();
    last_forces_.emplace_back(lambda.begin(), lambda.end());
  }
}

void MotionQuantities::report(Measured& measured) {
  if (displacement_)
    measured.fields["displacement"] = displacement_->take();
  std::map<std::string, double> numbers = contact_.numbers(problem_.scene.time.end);
  numbers["energy_loss"] = energy_ > 0 ? contact_loss_ / energy_ : 0;
  for (const auto& [name, value] : numbers)
    if (has(wanted_, name))
      measured.numbers[name] = value;
  if (pressure_)
    measured.numbers["pressure"] = pressure_error();
  if (restitution_)
    measured.numbers[of_restitution] =
        restitution_->value().value_or(std::numeric_limits<double>::quiet_NaN());
  measured.warnings = warnings_.warnings();
  if (stress_) {
    measured.numbers[of_stress] = stress_->peak()->stress.largest.value;
    std::ranges::move(stress_->warnings(), std::back_inserter(measured.warnings));
  }
}

double MotionQuantities::pressure_error() const {
  const scene::Field exact({*problem_.scene.exact->pressure}, "exact.pressure", false);
  const std::vector<double>& points = problem_.stepper.pairs()->points();
  std::vector<double> mean(points.size() / 3, 0.0);
  for (const std::vector<double>& force : last_forces_)
    for (std::size_t i = 0; i < mean.size(); ++i)
      mean[i] += force[i] / static_cast<double>(last_forces_.size());
  const std::vector<double> found = (*pressure_)(mean, problem_.grid.scheme(problem_.steps()).impulse());
  double error = 0, size = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double area = pressure_->area()[i];
    if (area <= 0)
      continue;
    double p = 0;
    exact.evaluate(&points[3 * i], 0, &p);
    error += area * (found[i] - p) * (found[i] - p);
    size += area * p * p;
  }
  return std::sqrt(error / size);
}

} // namespace signorini::accuracy
