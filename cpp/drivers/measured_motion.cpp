// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/measured_motion.h"
#include "diagnostics/contact_figures.h"
#include <algorithm>
#include <limits>

namespace signorini::drivers {
namespace {

/// The figures of contact that are measured and not fitted, of a motion that `watch` has seen.
std::vector<io::ComparedFigure> compared(const problem::Problem& problem,
                                         const diagnostics::ContactFigures& watch) {
  const scene::Scene& scene = problem.scene;
  const std::map<std::string, double> numbers = watch.numbers(scene.time.end);
  std::vector<io::ComparedFigure> all;
  for (const scene::Measurement& one : scene.measurements) {
    if (one.fitted())
      continue;
    std::string obstacle;
    if (one.obstacle && scene.contacts.size() > 1)
      obstacle = diagnostics::obstacle_suffix(static_cast<int>(
          std::ranges::find(scene.contacts, *one.obstacle, &scene::Contact::name) - scene.contacts.begin()));
    std::string quantity = scene::name(one.of);
    std::ranges::replace(quantity, '-', '_');
    const bool touched = numbers.at("contact_time" + obstacle) > 0;
    const double none =
        one.of == scene::Quantity::contact_time ? 0 : std::numeric_limits<double>::quiet_NaN();
    const bool force = one.of == scene::Quantity::sustained_peak;
    const char* unit = !force ? "s" : problem.space.dim() == 2 ? "N/m" : "N";
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
