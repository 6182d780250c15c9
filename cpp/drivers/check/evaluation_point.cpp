// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/check/evaluation_point.h"
#include <array>
#include <cmath>

namespace signorini::drivers {

void wave(const fem::Space& space, const std::vector<double>& points, const std::vector<int>& components,
          double t, int which, std::span<double> values) {
  const double unit = 2 * M_PI / space.mesh().diameter();
  const std::size_t n = components.size();
  constexpr std::array<double, 3> origin{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double* x = i / n * 3 < points.size() ? &points[i / n * 3] : origin.data(); // of virtual nodes
    const double c = components[i % n];
    values[i] =
        std::cos(unit * ((1 + c) * x[0] + 2 * x[1] - x[2]) + (1 + which) * 2 * M_PI * t + which + 0.7 * c);
  }
}

control::Control wave(const control::ControlSpace& controls, int which) {
  control::Control u = controls.zero();
  const double end = controls.grid().end();
  for (int j = 1; j <= u.count(); ++j) // in the middle of each interval
    wave(controls.space(), controls.points(), controls.components(),
         u.count() == 1 ? 0 : (controls.begin(j) + controls.length(j) / 2) / end, which, u.at(j));
  return u;
}

control::Control evaluation_point(const problem::Problem& problem,
                                  const problem::ControlProblem& control_problem, std::string& description) {
  const scene::Scene& scene = problem.scene;
  if (scene.control->stored) {
    description = "the control of control.initial.run";
    return control_problem.first_guess(scene);
  }
  if (scene.check.control) {
    description = "the control of [check]";
    return control_problem.controls.interpolate(*scene.check.control, "check.control");
  }
  if (control_problem.reference) {
    description = "the reference control, disturbed by a fifth of its norm";
    control::Control u = *control_problem.reference;
    constexpr int which = 2;
    const control::ControlSpace& controls = control_problem.controls;
    control::Control disturbance = wave(controls, which);
    const double part = 0.2 * controls.norm(u) / controls.norm(disturbance);
    for (int j = 1; j <= disturbance.count() && disturbance.count() > 1; ++j) {
      // The mean over an interval, as for every other control: the same wave for any steps.
      const double half = (1 + which) * M_PI * controls.length(j) / controls.grid().end();
      for (double& value : disturbance.at(j))
        value *= std::sin(half) / half;
    }
    u.add(part, disturbance);
    return u;
  }
  description = "the first guess";
  return control_problem.first_guess(scene);
}

} // namespace signorini::drivers
