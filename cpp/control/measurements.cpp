// SPDX-License-Identifier: GPL-3.0-or-later
#include "control/measurements.h"
#include "scene/targets.h"
#include <algorithm>
#include <cmath>

namespace signorini::control {
using scene::Quantity;

namespace {

/// Returns the functional that a measurement applies to a field: a component at a point of the undeformed
/// body, its mean over a group, or that of an obstacle with mass. Throws UserError naming `key`.
petsc::Vector functional_of(const step::Stepper& stepper, const scene::Scene& scene,
                            const scene::Measurement& measurement, const std::string& key) {
  const fem::Space& space = stepper.space();
  const auto component = static_cast<int>(*measurement.component);
  if (measurement.obstacle)
    return stepper.pairs()
        ->rigid(scene::obstacle_number(scene.contacts, *measurement.obstacle))
        ->weights(static_cast<std::size_t>(component));
  if (!measurement.point)
    return step::mean(space, fem::assemble_L2(space, *measurement.on, key + ".on"),
                      static_cast<std::size_t>(component))
        .weights;
  std::vector<double> x = *measurement.point;
  x.resize(3);
  const fem::Sampler sampler(space, x);
  step::require_inside(space, sampler, 0, *measurement.point, key);
  return sampler.functional(0, component);
}

} // namespace

Measurements::Measurements(const step::Stepper& stepper, const step::TimeGrid& grid,
                           const scene::Scene& scene, const std::vector<std::vector<double>>& times,
                           std::size_t columns)
    : stepper_(stepper), grid_(grid),
      alternate_(scene.contact_scheme() == scene::ContactScheme::contact_implicit || scene.frictional()),
      steps_(grid.steps()) {
  for (std::size_t i = 0; i < scene.measurements.size(); ++i) {
    const scene::Measurement& measurement = scene.measurements[i];
    first_.push_back(samples_.size());
    if (!measurement.fitted())
      continue;
    if (measurement.of == Quantity::displacement || measurement.of == Quantity::velocity) {
      const petsc::Vector functional = functional_of(stepper, scene, measurement, scene::measurement_key(i));
      channels_.push_back({.of = measurement.of, .field = step::SparseFunctional(functional)});
    } else {
      const int obstacle =
          measurement.obstacle ? scene::obstacle_number(scene.contacts, *measurement.obstacle) : -1;
      channels_.push_back(
          {.of = Quantity::force, .force = {obstacle, static_cast<int>(*measurement.component)}});
    }
    for (const double t : times[i])
      samples_.push_back({channels_.size() - 1, measurement.of == Quantity::impulse,
                          at(t, measurement.of == Quantity::force)});
  }
  first_.push_back(samples_.size());
  for (Channel& channel : channels_)
    channel.values.assign(columns, std::vector<double>(static_cast<std::size_t>(steps_) + 1));
}

std::vector<std::pair<int, double>> Measurements::at(double t, bool force) const {
  const auto [step, part] = grid_.place(t);
  if (!force)
    return {{step - 1, 1 - part}, {step, part}};
  if (!alternate_) { // forces belong to the middles of steps; none exist beyond the first and the last
    const int k = std::clamp(part < 0.5 ? step - 1 : step, 1, std::max(1, steps_ - 1)),
              next = std::min(k + 1, steps_);
    const double from = grid_.middle(k), to = grid_.middle(next),
                 weight = next > k ? std::clamp((t - from) / (to - from), 0.0, 1.0) : 0;
    return {{k, 1 - weight}, {next, weight}};
  }
  // The mean at t_k is over the impulses of the steps k and k + 1; at the end, over the last alone.
  std::vector<std::pair<int, double>> weights;
  for (const auto& [k, w] : {std::pair(step - 1, 1 - part), std::pair(step, part)}) {
    const int next = std::min(k + 1, steps_);
    const double first = grid_.length(std::max(k, 1)), second = grid_.length(next), both = first + second;
    weights.emplace_back(k, w * first / both);
    weights.emplace_back(next, w * second / both);
  }
  return weights;
}

double Measurements::force(int k, const Channel& channel, std::span<const double> lambda,
                           const contact::ConstraintRows& rows) const {
  return step::force_on_body(*stepper_.pairs(), rows, channel.force, lambda) / grid_.scheme(k).impulse();
}

void Measurements::take(int k, std::size_t column, Vec y, Vec v) {
  std::vector<double> sums;
  {
    const petsc::ReadArray at_y(y), at_v(v);
    for (const Channel& channel : channels_)
      sums.push_back(channel.field(channel.of == Quantity::velocity ? at_v : at_y));
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM,
                stepper_.space().comm());
  for (std::size_t i = 0; i < channels_.size(); ++i)
    if (channels_[i].of != Quantity::force)
      channels_[i].values[column][k] = sums[i];
}

void Measurements::observe(const trajectory::Frame& frame) {
  const auto k = static_cast<std::size_t>(frame.step.k);
  take(frame.step.k, 0, frame.after.y(), frame.after.v());
  for (Channel& channel : channels_)
    if (channel.of == Quantity::force)
      channel.values[0][k] =
          frame.step.k > 0 ? force(frame.step.k, channel, frame.contact.lambda, stepper_.pairs()->rows()) : 0;
}

void Measurements::observe(const trajectory::Frame& frame,
                           const trajectory::ParameterSensitivities& sensitivities,
                           const step::ParameterRates& rates) {
  observe(frame);
  const auto k = static_cast<std::size_t>(frame.step.k);
  for (std::size_t j = 0; j < sensitivities.count(); ++j) {
    take(frame.step.k, j + 1, sensitivities.y(j), sensitivities.v(j));
    for (Channel& channel : channels_) {
      if (channel.of != Quantity::force || frame.step.k == 0)
        continue;
      channel.values[j + 1][k] =
          force(frame.step.k, channel, sensitivities.lambda(j), stepper_.pairs()->rows());
      if (const contact::ConstraintRows* turning = rates.rows(j))
        channel.values[j + 1][k] += force(frame.step.k, channel, frame.contact.lambda, *turning);
    }
  }
}

std::vector<double> Measurements::values(std::size_t column) const {
  std::vector<std::vector<double>> sums(channels_.size()); // sums of forces so far
  std::vector<double> found;
  for (const Sample& sample : samples_) {
    const std::vector<double>* series = &channels_[sample.channel].values[column];
    if (sample.impulse) {
      std::vector<double>& sum = sums[sample.channel];
      for (std::size_t k = sum.size(); k < series->size(); ++k)
        sum.push_back(k > 0 ? sum.back() + grid_.length(static_cast<int>(k)) * (*series)[k] : 0);
      series = &sum;
    }
    double& value = found.emplace_back();
    for (const auto& [k, weight] : sample.weights)
      value += weight * (*series)[k];
  }
  return found;
}

void Measurements::set_derivative(std::span<const double> by_values) {
  const auto rows = static_cast<std::size_t>(steps_) + 1;
  std::vector<std::vector<double>> of_sums(channels_.size(), std::vector<double>(rows));
  derivative_.assign(channels_.size(), std::vector<double>(rows));
  for (std::size_t i = 0; i < samples_.size(); ++i)
    for (const auto& [k, weight] : samples_[i].weights)
      (samples_[i].impulse ? of_sums : derivative_)[samples_[i].channel][k] += weight * by_values[i];
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    double later = 0; // a force counts in all sums from its step on
    for (std::size_t k = rows; k-- > 0;) {
      later += of_sums[c][k];
      if (k > 0)
        derivative_[c][k] += grid_.length(static_cast<int>(k)) * later;
    }
  }
}

void Measurements::add(const step::TimeStep& step, step::StateDual sum) const {
  const petsc::WriteArray values(sum.vector);
  for (std::size_t c = 0; c < channels_.size(); ++c)
    if (channels_[c].of == Quantity::displacement)
      channels_[c].field.add_to(values, derivative_[c][step.k]);
}

std::size_t Measurements::velocities() const {
  return static_cast<std::size_t>(std::ranges::count(channels_, Quantity::velocity, &Channel::of));
}

void Measurements::velocity_factors(int k, std::span<double> factors) const {
  std::size_t i = 0;
  for (std::size_t c = 0; c < channels_.size(); ++c)
    if (channels_[c].of == Quantity::velocity)
      factors[i++] = derivative_[c][k];
}

void Measurements::add_velocities(std::span<const double> factors, Vec sum) const {
  const petsc::WriteArray values(sum);
  std::size_t i = 0;
  for (const Channel& channel : channels_)
    if (channel.of == Quantity::velocity)
      channel.field.add_to(values, factors[i++]);
}

bool Measurements::of_forces() const {
  return std::ranges::count(channels_, Quantity::force, &Channel::of) > 0;
}

void Measurements::forces(int k, std::span<double> dual) const {
  std::ranges::fill(dual, 0);
  for (std::size_t c = 0; c < channels_.size(); ++c)
    if (channels_[c].of == Quantity::force)
      step::add_force_dual(*stepper_.pairs(), channels_[c].force,
                           derivative_[c][k] / grid_.scheme(k).impulse(), dual);
}

double Measurements::by_rows(int k, const contact::ContactLinearisation& contact,
                             const contact::ConstraintRows& rate) const {
  std::vector<double> lambda(stepper_.rows());
  stepper_.pairs()->rows().spread(contact, lambda);
  double sum = 0;
  for (std::size_t c = 0; c < channels_.size(); ++c)
    if (channels_[c].of == Quantity::force)
      sum += derivative_[c][k] * force(k, channels_[c], lambda, rate);
  return sum;
}

} // namespace signorini::control
