#include "control/objective.h"
#include "base/counters.h"
#include <algorithm>
#include <array>
#include <cmath>

namespace signorini::control {
using petsc::check;

namespace {
long& objectives = count("objectives");
}

Objective::Objective(const ControlSpace& controls, const fem::Operators& operators, forward::TimeGrid grid,
                     std::unique_ptr<const forward::Displacements> desired, const scene::Objective& scene)
    : grid_(grid), desired_(std::move(desired)), tracking_(scene.tracking), alpha_(scene.alpha),
      gamma_(scene.gamma), controls_(controls),
      own_(scene.on ? fem::assemble_L2(controls.space(), *scene.on, "objective.on") : petsc::Matrix()),
      observed_(own_ ? Mat(own_) : Mat(*operators.W)), error_(controls.space().vector()),
      work_(controls.space().vector()) {
  ++objectives;
}

double Objective::tracking_weight(int k) const {
  return tracking_ * ((k > 0 ? grid_.length(k) : 0) + (k < grid_.steps() ? grid_.length(k + 1) : 0)) / 2;
}

double Objective::terminal_weight(int k) const { return k == grid_.steps() ? 2 * gamma_ : 0; }

double Objective::squared_distance(int k, Vec y) const {
  check(VecWAXPY(error_, -1, desired(k), y));
  check(MatMult(observed_, error_, work_));
  return petsc::dot(error_, work_);
}

double Objective::distance(int k, Vec y) const { return std::sqrt(squared_distance(k, y)); }

double Objective::norm(Vec y) const {
  check(MatMult(observed_, y, work_));
  return std::sqrt(petsc::dot(y, work_));
}

void Objective::observe(int k, Vec y, std::vector<double>& squared_distances) const {
  squared_distances.resize(std::max(squared_distances.size(), static_cast<std::size_t>(grid_.steps()) + 1));
  if (weight(k) != 0)
    squared_distances[static_cast<std::size_t>(k)] = squared_distance(k, y);
}

Value Objective::value(const std::vector<double>& squared_distances, const Control& u) const {
  Value value;
  for (int k = 0; k <= grid_.steps(); ++k) {
    const double squared = squared_distances[static_cast<std::size_t>(k)];
    value.tracking += tracking_weight(k) / 2 * squared;
    value.terminal += terminal_weight(k) / 2 * squared;
  }
  if (alpha_ > 0)
    value.control_cost = alpha_ / 2 * controls_.product(u, u);
  return value;
}

double Objective::quadrature_error(const std::vector<double>& squared_distances, const Control& u) const {
  constexpr int points = 3;
  if (grid_.steps() < points)
    return 0;
  // τ times the change of a time derivative from t = 0 to T, by one-sided differences of three values at each
  // end: `first` and `last` are the outermost numbers, `weights` those of the difference at t = 0, outermost
  // first.
  const auto change = [](auto&& at, int first, int last, const std::array<double, points>& weights) {
    double sum = 0;
    for (int i = 0; i < points; ++i)
      sum -= weights[static_cast<std::size_t>(i)] * (at(first + i) + at(last - i));
    return sum;
  };
  double error = 0;
  if (tracking_ > 0)
    error -= tracking_ * grid_.length(1) / 12 *
             change([&](int k) { return squared_distances[static_cast<std::size_t>(k)] / 2; }, 0,
                    grid_.steps(), {-1.5, 2, -0.5});
  if (alpha_ > 0 && u.count() == grid_.steps())
    error += alpha_ * grid_.length(1) / 24 *
             change([&](int k) { return controls_.product_at(k, u, u) / 2; }, 1, grid_.steps(), {-2, 3, -1});
  return error;
}

void Objective::add_derivative(int k, Vec y, forward::StateDual sum) const {
  add_weighted(k, y, desired(k), sum);
}

void Objective::add_second_derivative(int k, Vec dy, forward::StateDual sum) const {
  add_weighted(k, dy, nullptr, sum);
}

void Objective::add_weighted(int k, Vec y, Vec less, forward::StateDual sum) const {
  const Vec out = own_ ? Vec(work_) : sum.density;
  if (own_)
    check(VecZeroEntries(out));
  if (less)
    check(VecAXPBYPCZ(out, weight(k), -weight(k), 1, y, less));
  else
    check(VecAXPY(out, weight(k), y));
  if (own_)
    check(MatMultAdd(observed_, work_, sum.vector, sum.vector));
}

} // namespace signorini::control
