// SPDX-License-Identifier: GPL-3.0-or-later
#include "control/misfit.h"
#include "scene/parameters.h"
#include <cmath>
#include <limits>

namespace signorini::control {
namespace {

double on_scale(const scene::Unknown& unknown, double value) {
  return unknown.logarithmic() ? std::log(value) : value;
}

/// Returns the bounds of an unknown's x (θ or log θ): the given ones, otherwise natural ones.
std::pair<double, double> bounds_of(const scene::Unknown& unknown) {
  constexpr double nearly = 1e-6; // distance from limits that are excluded
  const scene::Limits natural = scene::natural_limits(unknown.of);
  const double inside = natural.open ? nearly : 0;
  double lower = natural.least + inside, upper = natural.greatest - inside;
  if (natural.open && natural.least == 0)
    lower = std::numeric_limits<double>::min(); // in whatever unit
  if (unknown.logarithmic()) {
    // The curvature of J by log θ falls with θ² towards 0, and with 1/θ² towards ∞. Beyond the root of the
    // rounding it is rounding of J, and a search finds no minimum.
    const double root = std::sqrt(std::numeric_limits<double>::epsilon());
    lower = std::max(lower, root * unknown.start);
    upper = std::min(upper, unknown.start / root);
  }
  lower = unknown.lower.value_or(std::min(lower, unknown.start));
  upper = unknown.upper.value_or(std::max(upper, unknown.start));
  return {on_scale(unknown, lower), on_scale(unknown, upper)};
}

/// Returns the largest change of an unknown's x (θ or log θ) in one step. A change of log θ by −1 takes the
/// linearised θ (1 + δ) to 0, a change by +1 the linearised 1/θ; a longer step has no meaning.
double longest_step(const scene::Unknown& unknown) {
  return unknown.logarithmic() ? 1 : std::numeric_limits<double>::infinity();
}

} // namespace

Misfit::Misfit(const scene::Scene& scene, std::vector<Data> data) : scene_(scene), data_(std::move(data)) {
  for (const Data& one : data_)
    count_ += one.times.size();
  for (const scene::Unknown& unknown : scene.unknowns) {
    const auto [lower, upper] = bounds_of(unknown);
    box_.lower.push_back(lower);
    box_.upper.push_back(upper);
    box_.longest.push_back(longest_step(unknown));
  }
}

std::vector<double> Misfit::values(std::span<const double> x) const {
  std::vector<double> theta;
  for (std::size_t j = 0; j < x.size(); ++j)
    theta.push_back(scene_.unknowns[j].logarithmic() ? std::exp(x[j]) : x[j]);
  return theta;
}

std::vector<double> Misfit::on_scales(std::span<const double> values) const {
  std::vector<double> x;
  for (std::size_t j = 0; j < values.size(); ++j)
    x.push_back(on_scale(scene_.unknowns[j], values[j]));
  return x;
}

std::vector<double> Misfit::slopes(std::span<const double> x) const {
  std::vector<double> slopes = values(x);
  for (std::size_t j = 0; j < x.size(); ++j)
    if (!scene_.unknowns[j].logarithmic())
      slopes[j] = 1;
  return slopes;
}

std::vector<std::vector<double>> Misfit::times() const {
  std::vector<std::vector<double>> times;
  for (const Data& one : data_)
    times.push_back(one.times);
  return times;
}

std::vector<scene::TableWarning> Misfit::warnings() const {
  std::vector<scene::TableWarning> all;
  for (const Data& one : data_)
    all.insert(all.end(), one.warnings.begin(), one.warnings.end());
  return all;
}

std::vector<double> Misfit::residuals(const std::vector<double>& simulated, std::span<const double> x) const {
  std::vector<double> r;
  for (const Data& one : data_)
    for (std::size_t k = 0; k < one.times.size(); ++k)
      r.push_back((simulated[r.size()] - one.values[k]) / one.deviations[k]);
  for (std::size_t j = 0; j < x.size(); ++j)
    if (const auto& prior = scene_.unknowns[j].prior)
      r.push_back((x[j] - on_scale(scene_.unknowns[j], prior->mean)) / prior->deviation);
  return r;
}

std::vector<double> Misfit::jacobian(const std::vector<std::vector<double>>& by_theta,
                                     std::span<const double> x) const {
  std::vector<double> jacobian;
  const std::vector<double> slope = slopes(x);
  for (std::size_t j = 0; j < x.size(); ++j) {
    std::vector<double> column = by_theta[j];
    std::size_t i = 0;
    for (const Data& one : data_)
      for (const double deviation : one.deviations)
        column[i++] *= slope[j] / deviation;
    for (std::size_t p = 0; p < x.size(); ++p)
      if (const auto& prior = scene_.unknowns[p].prior)
        column.push_back(p == j ? 1 / prior->deviation : 0);
    jacobian.insert(jacobian.end(), column.begin(), column.end());
  }
  return jacobian;
}

std::vector<double> Misfit::by_values(const std::vector<double>& residuals) const {
  std::vector<double> derivative;
  for (const Data& one : data_)
    for (const double deviation : one.deviations)
      derivative.push_back(residuals[derivative.size()] / deviation);
  return derivative;
}

std::vector<double> Misfit::gradient(std::vector<double> by_theta, const std::vector<double>& residuals,
                                     std::span<const double> x) const {
  const std::vector<double> slope = slopes(x);
  std::size_t next = count_;
  for (std::size_t j = 0; j < x.size(); ++j) {
    by_theta[j] *= slope[j];
    if (const auto& prior = scene_.unknowns[j].prior)
      by_theta[j] += residuals[next++] / prior->deviation;
  }
  return by_theta;
}

} // namespace signorini::control
