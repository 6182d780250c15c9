// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/fit_outcome.h"
#include "diagnostics/contact_forces.h"
#include "scene/targets.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <numeric>
#include <tuple>

namespace signorini::drivers {

namespace {

std::string power(const std::string& name, double exponent) {
  return std::abs(exponent - 1) < 1e-3 ? name : fmt::format("{}^{:.3g}", name, exponent);
}

/// Sentence on two unknowns on logarithmic scales, of which the data determine only a product of powers.
std::string pair_of_logs(const std::string& a, const std::string& b, double slope) {
  constexpr double alike = 1e-3;
  if (std::abs(slope - 1) < alike)
    return fmt::format("The data determine only the ratio of {} and {}.", a, b);
  if (std::abs(slope + 1) < alike)
    return fmt::format("The data determine only the product of {} and {}.", a, b);
  return fmt::format("The data determine {} and {} only in the combination {} {} {}.", a, b, power(b, 1),
                     slope > 0 ? "/" : "times", power(a, std::abs(slope)));
}

/// Simulated value of a quantity that is only compared, as text.
std::string simulated(const io::ComparedQuantity& one) {
  if (std::isnan(one.simulated))
    return "no contact";
  const std::string deviations = one.deviation > 0 ? fmt::format(", off by {:+.2f} standard deviations",
                                                                 (one.simulated - one.value) / one.deviation)
                                                   : "";
  return fmt::format("{:.6g} {}{}", one.simulated, one.unit, deviations);
}

/// Adds dJ/dθ and the standard deviations of θ to a fit.
void take_deviations(const problem::ParameterProblem& problem, const optimize::GaussNewtonIterate& last,
                     const optimize::Identified& known, io::Fit& fit) {
  const std::vector<double> slope = problem.misfit.slopes(last.x), g = last.at.gradient();
  for (std::size_t j = 0; j < fit.unknowns.size(); ++j) {
    fit.unknowns[j].deviation = known.deviations[j] * slope[j];
    fit.unknowns[j].gradient = g[j] / slope[j];
  }
}

/// Adds sentences about unknowns that are poorly identified.
void add_poorly_identified(const problem::ParameterProblem& problem, const optimize::GaussNewtonIterate& last,
                           const optimize::Identified& known, io::Fit& fit) {
  for (std::size_t j = 0; j < fit.unknowns.size(); ++j) {
    const scene::Unknown& unknown = problem.scene.unknowns[j];
    const double deviation = known.deviations[j];
    if (!std::isfinite(deviation))
      continue;
    if (!unknown.logarithmic()) {
      constexpr double far = 10;
      const io::FittedUnknown& found = fit.unknowns[j];
      const double size = std::max(std::abs(found.value), std::abs(unknown.start));
      if (size > 0 && found.deviation > far * size)
        fit.unidentified.push_back(fmt::format(
            "{} is poorly identified: its standard deviation is {:.3g} times the larger of its value "
            "and its first guess. Unless it is about 0, the data do not determine it.",
            unknown.name, found.deviation / size));
      continue;
    }
    if (!unknown.lower && last.x[j] <= problem.misfit.box().lower[j])
      fit.unidentified.push_back(
          fmt::format("{} fell to the lower end of its logarithmic scale, {:.2g} times its first guess: the "
                      "data show only that it is small. With scale = \"linear\" the unknown can reach its "
                      "natural lower limit.",
                      unknown.name, fit.unknowns[j].value / unknown.start));
    else if (!unknown.upper && last.x[j] >= problem.misfit.box().upper[j])
      fit.unidentified.push_back(fmt::format("{} rose to the upper end of its logarithmic scale, {:.2g} "
                                             "times its first guess: the data show only that it is large.",
                                             unknown.name, fit.unknowns[j].value / unknown.start));
    else if (deviation > std::log(2))
      fit.unidentified.push_back(
          fmt::format("{} is poorly identified: its standard deviation is {:.3g} times its value.",
                      unknown.name, deviation));
  }
}

/// Finds the most strongly correlated pair of unknowns; there must be at least two.
std::string largest_correlation(const io::Fit& fit) {
  const std::size_t n = fit.unknowns.size();
  std::size_t first = 0, second = 1;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j)
      if (std::abs(fit.correlations[i * n + j]) > std::abs(fit.correlations[first * n + second]))
        std::tie(first, second) = std::pair(i, j);
  return fmt::format("{}: {:+.2f}, of {} and {}", n == 2 ? "correlation" : "largest correlation",
                     fit.correlations[first * n + second], fit.unknowns[first].name,
                     fit.unknowns[second].name);
}

} // namespace

std::string unidentified(const std::vector<scene::Unknown>& unknowns, const std::vector<double>& direction) {
  std::vector<std::size_t> which;
  for (std::size_t j = 0; j < direction.size(); ++j)
    if (direction[j] != 0)
      which.push_back(j);
  if (which.size() == 1)
    return fmt::format("The data do not determine {}.", unknowns[which.front()].name);
  const auto name = [&](std::size_t i) { return unknowns[which[i]].name; };
  if (which.size() == 2 && unknowns[which[0]].logarithmic() && unknowns[which[1]].logarithmic())
    return pair_of_logs(name(0), name(1), direction[which[1]] / direction[which[0]]);
  std::vector<std::string> names, changes;
  for (const std::size_t j : which) {
    names.push_back(unknowns[j].name);
    changes.push_back(fmt::format("{} by {:+.3g}{}", unknowns[j].name, direction[j],
                                  unknowns[j].logarithmic() ? " (relative)" : ""));
  }
  return fmt::format(
      "The data do not separate {}: joint changes in the proportion {} leave all simulated values unchanged.",
      fmt::join(names, ", "), fmt::join(changes, ", "));
}

io::Fit outcome(const problem::ParameterProblem& problem, const optimize::GaussNewtonIterate& last,
                const std::vector<double>& values) {
  const scene::Scene& scene = problem.scene;
  const std::vector<double> theta = problem.misfit.values(last.x),
                            lower = problem.misfit.values(problem.misfit.box().lower),
                            upper = problem.misfit.values(problem.misfit.box().upper);
  io::Fit fit;
  for (std::size_t j = 0; j < scene.unknowns.size(); ++j) {
    const scene::Unknown& unknown = scene.unknowns[j];
    fit.unknowns.push_back({.name = unknown.name,
                            .quantity = scene::name(unknown.of),
                            .unit = scene::unit(scene, unknown, problem.discretisation->space.dim()),
                            .scale = scene::name(unknown.scale),
                            .value = theta[j],
                            .start = unknown.start,
                            .lower = lower[j],
                            .upper = upper[j],
                            .at_bound = last.x[j] <= problem.misfit.box().lower[j] ||
                                        last.x[j] >= problem.misfit.box().upper[j]});
  }
  const optimize::Identified known = optimize::identified(last.at.normal_matrix(), scene.unknowns.size());
  take_deviations(problem, last, known, fit);
  fit.correlations = known.correlations;
  fit.singular_values = known.singular_values;
  for (const std::vector<double>& direction : known.unidentified)
    fit.unidentified.push_back(unidentified(scene.unknowns, direction));
  add_poorly_identified(problem, last, known, fit);
  std::size_t at = 0;
  double squares = 0;
  for (std::size_t i = 0; i < scene.measurements.size(); ++i) {
    const control::Data& data = problem.misfit.data()[i];
    if (data.times.empty())
      continue;
    io::Comparison& one = fit.measurements.emplace_back();
    one = {scene.measurements[i].name, data.times, data.values, data.deviations, {}};
    for (std::size_t k = 0; k < data.times.size(); ++k) {
      one.simulated.push_back(values[at++]);
      squares += std::pow((one.simulated[k] - data.values[k]) / data.deviations[k], 2);
    }
  }
  fit.data = static_cast<long>(at);
  fit.misfit = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(at, 1)));
  fit.value = last.at.value();
  fit.decrement = last.decrement;
  return fit;
}

std::optional<Warning> misfit_warning(const io::Fit& fit) {
  // Chance alone exceeds this in at most one fit in 200: χ² of one degree of freedom, two values and one
  // unknown.
  constexpr double limit = 2;
  if (!(fit.misfit > limit))
    return std::nullopt;
  return Warning{
      "misfit of the data",
      fmt::format("the residuals are {:.3g} times as large as the noise of the data (root mean square): this "
                  "fit does not explain the data. Another first guess may lead to a lower minimum. Otherwise "
                  "the model is wrong, or the deviations are too small",
                  fit.misfit),
      fit.misfit, limit};
}

std::vector<std::string> outcome_lines(const io::Fit& fit) {
  std::size_t width = 7;
  for (const io::FittedUnknown& one : fit.unknowns)
    width = std::max(width, one.name.size());
  std::vector<std::string> lines{
      fmt::format("{:<{}}  {:>14}  {:>12}  {:>12}", "unknown", width, "value", "deviation", "start")};
  for (const io::FittedUnknown& one : fit.unknowns)
    lines.push_back(
        fmt::format("{:<{}}  {:>14.8g}  {:>12}  {:>12.6g}  {}{}", one.name, width, one.value,
                    std::isfinite(one.deviation) ? fmt::format("{:.3g}", one.deviation) : "undetermined",
                    one.start, one.unit, one.at_bound ? " (at its bound)" : ""));
  if (fit.unknowns.size() > 1)
    lines.push_back(largest_correlation(fit));
  for (const std::string& sentence : fit.unidentified)
    lines.push_back(sentence);
  for (const io::ComparedQuantity& one : fit.compared)
    lines.push_back(
        fmt::format("{}: measured {:.6g} {}, simulated {}", one.name, one.value, one.unit, simulated(one)));
  lines.push_back(fmt::format("misfit of {} values: {:.3g} standard deviations (root mean square)", fit.data,
                              fit.misfit));
  return lines;
}

namespace {

/// Contact quantities that are measured but not fitted, for the motion that `watch` has observed.
std::vector<io::ComparedQuantity> compared(const problem::Problem& problem,
                                           const diagnostics::ContactFigures& watch) {
  const scene::Scene& scene = problem.scene;
  const std::map<std::string, double> numbers = watch.numbers(scene.time.end);
  std::vector<io::ComparedQuantity> all;
  for (const scene::Measurement& one : scene.measurements) {
    if (one.fitted())
      continue;
    std::string obstacle;
    if (one.obstacle && scene.contacts.size() > 1)
      obstacle = diagnostics::obstacle_suffix(scene::obstacle_number(scene.contacts, *one.obstacle));
    std::string quantity = scene::name(one.of);
    std::ranges::replace(quantity, '-', '_');
    const bool touched = numbers.at("contact_time" + obstacle) > 0;
    const double none =
        one.of == scene::Quantity::contact_time ? 0 : std::numeric_limits<double>::quiet_NaN();
    const bool force = one.of == scene::Quantity::sustained_peak;
    const std::string unit = force ? std::string("N") + problem.space.mesh().per_depth() : "s";
    all.push_back({one.name, unit, *one.value, one.deviation.value_or(0),
                   touched ? numbers.at(quantity + obstacle) : none});
  }
  return all;
}

} // namespace

Simulated simulate_measured(const problem::Problem& problem, const problem::ParameterProblem& fit,
                            const step::ForceAtStep& load, MotionWriter& recorder) {
  const auto timer = problem.timers.time("replay");
  control::Measurements measurements(problem.stepper, problem.grid, problem.scene, fit.misfit.times());
  diagnostics::ContactFigures contact(problem.stepper);
  trajectory::integrate(
      problem.stepper, problem.grid, problem.initial, load,
      [&](const trajectory::Frame& frame) {
        recorder(frame);
        measurements.observe(frame);
        contact(frame);
      },
      trajectory::Stops::ignored);
  recorder.finish();
  return {measurements.values(), compared(problem, contact)};
}

} // namespace signorini::drivers
