#include "control/objective.h"
#include "base/counters.h"
#include <cmath>

namespace signorini::control {
using petsc::check;

namespace {
long& objectives = count("objectives");
}

Objective::Objective(const ControlSpace& controls, forward::Scheme scheme, petsc::Series desired,
                     double alpha, double gamma)
    : scheme_(scheme), desired_(std::move(desired)), alpha_(alpha), gamma_(gamma), controls_(controls),
      error_(controls.space().vector()) {
  ++objectives;
}

double Objective::tracking_weight(int k) const {
  return k == 0 || k == controls_.steps() ? scheme_.tau / 2 : scheme_.tau;
}

double Objective::terminal_weight(int k) const { return k == controls_.steps() ? 2 * gamma_ : 0; }

double Objective::squared_distance(int k, Vec y) const {
  check(VecWAXPY(error_, -1, desired_[static_cast<std::size_t>(k)], y));
  return controls_.dot(error_, error_);
}

double Objective::distance(int k, Vec y) const { return std::sqrt(squared_distance(k, y)); }

Value Objective::value(const forward::Trajectory& trajectory, const Control& u) const {
  Value value;
  for (int k = 0; k <= controls_.steps(); ++k) {
    const double squared = squared_distance(k, trajectory.y[static_cast<std::size_t>(k)]);
    value.tracking += tracking_weight(k) / 2 * squared;
    value.terminal += terminal_weight(k) / 2 * squared;
  }
  value.control_cost = alpha_ / 2 * controls_.product(u, u);
  return value;
}

void Objective::add_derivative(int k, Vec y, Vec density) const {
  const double weight = tracking_weight(k) + terminal_weight(k);
  check(VecAXPBYPCZ(density, weight, -weight, 1, y, desired_[static_cast<std::size_t>(k)]));
}

void Objective::add_second_derivative(int k, Vec delta, Vec density) const {
  check(VecAXPY(density, tracking_weight(k) + terminal_weight(k), delta));
}

} // namespace signorini::control
