#include "control/objective.h"
#include "base/counters.h"
#include <cmath>

namespace signorini::control {
using petsc::check;

namespace {
long& objectives = count("objectives");
}

Objective::Objective(const ControlSpace& controls, const fem::Operators& operators, forward::Scheme scheme,
                     petsc::Series desired, const scene::Objective& scene)
    : scheme_(scheme), steps_(controls.steps()), desired_(std::move(desired)), tracking_(scene.tracking),
      alpha_(scene.alpha), gamma_(scene.gamma), controls_(controls),
      own_(scene.on ? fem::assemble_L2(controls.space(), *scene.on, "objective.on") : petsc::Matrix()),
      observed_(own_ ? Mat(own_) : Mat(*operators.W)), error_(controls.space().vector()),
      work_(controls.space().vector()) {
  ++objectives;
}

double Objective::tracking_weight(int k) const {
  return tracking_ * (k == 0 || k == steps_ ? scheme_.tau / 2 : scheme_.tau);
}

double Objective::terminal_weight(int k) const { return k == steps_ ? 2 * gamma_ : 0; }

double Objective::squared_distance(int k, Vec y) const {
  check(VecWAXPY(error_, -1, desired_[static_cast<std::size_t>(k)], y));
  check(MatMult(observed_, error_, work_));
  return petsc::dot(error_, work_);
}

double Objective::distance(int k, Vec y) const { return std::sqrt(squared_distance(k, y)); }

Value Objective::value(const forward::Trajectory& trajectory, const Control& u) const {
  Value value;
  for (int k = 0; k <= steps_; ++k) {
    if (tracking_weight(k) + terminal_weight(k) == 0)
      continue;
    const double squared = squared_distance(k, trajectory.y[static_cast<std::size_t>(k)]);
    value.tracking += tracking_weight(k) / 2 * squared;
    value.terminal += terminal_weight(k) / 2 * squared;
  }
  if (alpha_ > 0)
    value.control_cost = alpha_ / 2 * controls_.product(u, u);
  return value;
}

double Objective::quadrature_error(const forward::Trajectory& trajectory) const {
  if (tracking_ == 0 || steps_ < 2)
    return 0;
  // 2 τ (½ ‖e‖²)' at an end from the three points next to it.
  const auto rate = [&](int end, int inwards) {
    const auto at = [&](int k) { return squared_distance(k, trajectory.y[static_cast<std::size_t>(k)]) / 2; };
    return -inwards * (3 * at(end) - 4 * at(end + inwards) + at(end + 2 * inwards));
  };
  return -tracking_ * scheme_.tau / 24 * (rate(steps_, -1) - rate(0, 1));
}

forward::Load Objective::dual(std::function<void(int k, double weight, Vec out)> add) const {
  const auto weight = [this](int k) { return tracking_weight(k) + terminal_weight(k); };
  forward::Load load;
  if (own_)
    load.force = [=, this](int k, Vec out) {
      if (weight(k) == 0)
        return;
      check(VecZeroEntries(work_));
      add(k, weight(k), work_);
      check(MatMultAdd(observed_, work_, out, out));
    };
  else
    load.density = [=](int k, Vec out) {
      if (weight(k) != 0)
        add(k, weight(k), out);
    };
  return load;
}

forward::Load Objective::derivative(const forward::Trajectory& trajectory) const {
  return dual([this, &trajectory](int k, double weight, Vec out) {
    const auto i = static_cast<std::size_t>(k);
    check(VecAXPBYPCZ(out, weight, -weight, 1, trajectory.y[i], desired_[i]));
  });
}

forward::Load Objective::second_derivative(const petsc::Series& dy) const {
  return dual([&dy](int k, double weight, Vec out) {
    check(VecAXPY(out, weight, dy[static_cast<std::size_t>(k) - 1]));
  });
}

} // namespace signorini::control
