// SPDX-License-Identifier: GPL-3.0-or-later
#include "control/measurements.h"
#include "base/error.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace signorini::control {
using petsc::check;
using scene::Quantity;

namespace {

/// The owned entries of a functional that are not zero.
std::vector<std::pair<int, double>> entries(Vec functional) {
  std::vector<std::pair<int, double>> row;
  const petsc::ReadArray values(functional);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] != 0)
      row.emplace_back(static_cast<int>(i), values[i]);
  return row;
}

void add_row(const std::vector<std::pair<int, double>>& row, double factor, std::span<double> sum) {
  for (const auto& [dof, weight] : row)
    sum[static_cast<std::size_t>(dof)] += factor * weight;
}

/// The functional of one component at a point of the undeformed body. Throws UserError naming `key`.
petsc::Vector at_point(const fem::Space& space, const std::vector<double>& point, int component,
                       const std::string& key) {
  std::vector<double> x = point;
  x.resize(3);
  const fem::Sampler sampler(space, x);
  const double outside = 0.01 * space.mesh().diameter(); // as of probes
  if (const double distance = sampler.distances().front(); distance > outside)
    throw UserError(fmt::format(
        "{}.point: found ({:.6g}), which is {:.4g} m outside of the body, allowed are points of the "
        "undeformed body",
        key, fmt::join(point, ", "), distance));
  return sampler.functional(0, component);
}

/// The functional of the mean of a component over a group. Throws UserError naming `key`.
petsc::Vector mean_over(const fem::Space& space, const std::string& group, int component,
                        const std::string& key) {
  const petsc::Matrix L2 = fem::assemble_L2(space, group, key + ".on");
  const petsc::Vector e = space.vector();
  {
    const petsc::WriteArray values(e);
    for (std::size_t i = static_cast<std::size_t>(component); i < values.size();
         i += static_cast<std::size_t>(space.dim()))
      values[i] = 1;
  }
  petsc::Vector mean = space.vector();
  check(MatMult(L2, e, mean));
  check(VecScale(mean, 1 / petsc::dot(e, mean)));
  return mean;
}

} // namespace

Measurements::Measurements(const step::Stepper& stepper, const step::TimeGrid& grid,
                           const scene::Scene& scene, const std::vector<std::vector<double>>& times,
                           std::size_t columns)
    : stepper_(stepper), grid_(grid),
      alternate_(scene.contact_scheme() == scene::ContactScheme::contact_implicit), steps_(grid.steps()) {
  for (std::size_t i = 0; i < scene.measurements.size(); ++i) {
    const scene::Measurement& measurement = scene.measurements[i];
    first_.push_back(samples_.size());
    if (!measurement.fitted())
      continue;
    if (measurement.of == Quantity::displacement || measurement.of == Quantity::velocity)
      add_field(measurement, scene::measurement_key(i));
    else {
      const auto named =
          std::ranges::find(scene.contacts, measurement.obstacle.value_or(""), &scene::Contact::name);
      channels_.push_back(
          {.of = Quantity::force,
           .component = static_cast<int>(*measurement.component),
           .obstacle = measurement.obstacle ? static_cast<int>(named - scene.contacts.begin()) : -1});
    }
    for (const double t : times[i])
      samples_.push_back({channels_.size() - 1, measurement.of == Quantity::impulse,
                          at(t, measurement.of == Quantity::force)});
  }
  first_.push_back(samples_.size());
  for (Channel& channel : channels_)
    channel.values.assign(columns, std::vector<double>(static_cast<std::size_t>(steps_) + 1));
}

void Measurements::add_field(const scene::Measurement& measurement, const std::string& key) {
  const auto component = static_cast<int>(*measurement.component);
  const petsc::Vector functional = measurement.point
                                       ? at_point(stepper_.space(), *measurement.point, component, key)
                                       : mean_over(stepper_.space(), *measurement.on, component, key);
  channels_.push_back({.of = measurement.of, .row = entries(functional)});
}

std::vector<std::pair<int, double>> Measurements::at(double t, bool force) const {
  const auto [step, part] = grid_.place(t);
  if (!force)
    return {{step - 1, 1 - part}, {step, part}};
  if (!alternate_) { // forces of steps stand in their middle, and none before the first and after the last
    const int k = std::clamp(part < 0.5 ? step - 1 : step, 1, std::max(1, steps_ - 1)),
              next = std::min(k + 1, steps_);
    const double from = grid_.middle(k), to = grid_.middle(next),
                 weight = next > k ? std::clamp((t - from) / (to - from), 0.0, 1.0) : 0;
    return {{k, 1 - weight}, {next, weight}};
  }
  // The mean at t_k is of the impulses of the steps k and k + 1; at the end, of the last alone.
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
  const contact::ContactPairs& pairs = *stepper_.pairs();
  double sum = 0;
  for (int i = 0; i < pairs.count(); ++i)
    if (channel.obstacle < 0 || pairs.obstacles()[static_cast<std::size_t>(i)] == channel.obstacle)
      sum -= pairs.force(rows, i, channel.component, lambda);
  return sum / grid_.scheme(k).impulse();
}

void Measurements::take(int k, std::size_t column, Vec y, Vec v) {
  std::vector<double> sums;
  {
    const petsc::ReadArray at_y(y), at_v(v);
    for (const Channel& channel : channels_) {
      double& sum = sums.emplace_back();
      for (const auto& [dof, weight] : channel.row)
        sum += weight * (channel.of == Quantity::velocity ? at_v : at_y)[static_cast<std::size_t>(dof)];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM,
                stepper_.space().comm());
  for (std::size_t i = 0; i < channels_.size(); ++i)
    if (channels_[i].of != Quantity::force)
      channels_[i].values[column][static_cast<std::size_t>(k)] = sums[i];
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
  std::vector<std::vector<double>> sums(channels_.size()); // of forces so far
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
      value += weight * (*series)[static_cast<std::size_t>(k)];
  }
  return found;
}

void Measurements::set_derivative(std::span<const double> by_values) {
  const auto rows = static_cast<std::size_t>(steps_) + 1;
  std::vector<std::vector<double>> of_sums(channels_.size(), std::vector<double>(rows));
  derivative_.assign(channels_.size(), std::vector<double>(rows));
  for (std::size_t i = 0; i < samples_.size(); ++i)
    for (const auto& [k, weight] : samples_[i].weights)
      (samples_[i].impulse ? of_sums : derivative_)[samples_[i].channel][static_cast<std::size_t>(k)] +=
          weight * by_values[i];
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
      add_row(channels_[c].row, derivative_[c][static_cast<std::size_t>(step.k)], values);
}

std::size_t Measurements::velocities() const {
  return static_cast<std::size_t>(std::ranges::count(channels_, Quantity::velocity, &Channel::of));
}

void Measurements::velocity_factors(int k, std::span<double> factors) const {
  std::size_t i = 0;
  for (std::size_t c = 0; c < channels_.size(); ++c)
    if (channels_[c].of == Quantity::velocity)
      factors[i++] = derivative_[c][static_cast<std::size_t>(k)];
}

void Measurements::add_velocities(std::span<const double> factors, Vec sum) const {
  const petsc::WriteArray values(sum);
  std::size_t i = 0;
  for (const Channel& channel : channels_)
    if (channel.of == Quantity::velocity)
      add_row(channel.row, factors[i++], values);
}

bool Measurements::of_forces() const {
  return std::ranges::count(channels_, Quantity::force, &Channel::of) > 0;
}

void Measurements::forces(int k, std::span<double> dual) const {
  std::ranges::fill(dual, 0);
  const contact::ContactPairs& pairs = *stepper_.pairs();
  const contact::ConstraintRows& rows = pairs.rows();
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    const Channel& channel = channels_[c];
    if (channel.of != Quantity::force)
      continue;
    const double factor = derivative_[c][static_cast<std::size_t>(k)] / grid_.scheme(k).impulse();
    for (int i = 0; i < pairs.count(); ++i)
      if (channel.obstacle < 0 || pairs.obstacles()[static_cast<std::size_t>(i)] == channel.obstacle)
        for (std::size_t r = 0; r < rows.size(i); ++r)
          dual[rows.row(i, r)] -= factor * pairs.at_node(rows, i, r, channel.component);
  }
}

double Measurements::by_rows(int k, const contact::ContactLinearisation& contact,
                             const contact::ConstraintRows& rate) const {
  std::vector<double> lambda(stepper_.rows());
  stepper_.pairs()->rows().spread(contact, lambda);
  double sum = 0;
  for (std::size_t c = 0; c < channels_.size(); ++c)
    if (channels_[c].of == Quantity::force)
      sum += derivative_[c][static_cast<std::size_t>(k)] * force(k, channels_[c], lambda, rate);
  return sum;
}

} // namespace signorini::control
