// SPDX-License-Identifier: GPL-3.0-or-later
#include "control/objective.h"
#include "base/timers.h"
#include "contact/rigid_body.h"
#include "scene/targets.h"
#include <algorithm>
#include <cmath>
#include <utility>

namespace signorini::control {
using petsc::check;

namespace {

long& objectives = count("objectives");

/// Returns the matrix of the product of the set that an objective observes; null for the whole body.
/// Collective.
petsc::Matrix product_of(const fem::Space& space, const scene::Scene& scene) {
  if (scene.objective->on)
    return fem::assemble_L2(space, *scene.objective->on, "objective.on");
  if (!scene.objective->obstacle)
    return {};
  const int obstacle = scene::obstacle_number(scene.contacts, *scene.objective->obstacle);
  const auto dim = static_cast<std::size_t>(space.dim()),
             node = contact::virtual_node(scene.contacts, static_cast<std::size_t>(obstacle));
  std::vector<double> diagonal(dim * space.layout().virtual_nodes().size());
  std::fill_n(diagonal.begin() + static_cast<std::ptrdiff_t>(dim * node), dim, 1.0);
  return space.layout().diagonal(diagonal);
}

} // namespace

ObservedSet::ObservedSet(const fem::Space& space, const fem::Operators& operators, const scene::Scene& scene)
    : own_(product_of(space, scene)), product_(own_ ? Mat(own_) : Mat(*operators.W)),
      difference_(space.vector()), work_(space.vector()) {
  ++objectives;
}

double ObservedSet::squared_distance(Vec y, Vec other) const {
  check(VecWAXPY(difference_, -1, other, y));
  check(MatMult(product_, difference_, work_));
  return petsc::dot(difference_, work_);
}

double ObservedSet::norm(Vec y) const {
  check(MatMult(product_, y, work_));
  return std::sqrt(petsc::dot(y, work_));
}

TimeWeights::TimeWeights(const scene::Objective& scene, step::TimeGrid grid)
    : grid_(std::move(grid)), tracking_(scene.tracking), alpha_(scene.alpha), gamma_(scene.gamma) {}

double TimeWeights::tracking_at(int k) const { // θ (τ_k + τ_{k+1})/2, the trapezoidal rule
  return tracking_ * ((k > 0 ? grid_.length(k) : 0) + (k < grid_.steps() ? grid_.length(k + 1) : 0)) / 2;
}

double TimeWeights::terminal_at(int k) const { return k == grid_.steps() ? 2 * gamma_ : 0; }

ObjectiveValue TimeWeights::value(const std::vector<double>& squared_distances, const ControlSpace& controls,
                                  const Control& u) const {
  ObjectiveValue value;
  // Σ_k θ (τ_k + τ_{k+1})/4 |e_k|² + γ |e_N|² + α/2 Σ τ_k |u_k|² (method.md, section 3)
  for (int k = 0; k <= grid_.steps(); ++k) {
    const double squared = squared_distances[k];
    value.tracking += tracking_at(k) / 2 * squared;
    value.terminal += terminal_at(k) / 2 * squared;
  }
  if (alpha_ > 0)
    value.control_cost = alpha_ / 2 * controls.product(u, u);
  return value;
}

Objective::Objective(const ControlSpace& controls, const fem::Operators& operators, step::TimeGrid grid,
                     std::unique_ptr<const step::Displacements> desired, const scene::Scene& scene)
    : weights_(*scene.objective, std::move(grid)), desired_(std::move(desired)), controls_(controls),
      observed_(controls.space(), operators, scene), work_(controls.space().vector()) {}

double Objective::squared_distance(int k, Vec y) const { return observed_.squared_distance(y, desired(k)); }

double Objective::distance(int k, Vec y) const { return std::sqrt(squared_distance(k, y)); }

void Objective::observe(int k, Vec y, std::vector<double>& squared_distances) const {
  squared_distances.resize(
      std::max(squared_distances.size(), static_cast<std::size_t>(weights_.grid().steps()) + 1));
  if (weight(k) != 0)
    squared_distances[k] = squared_distance(k, y);
}

double Objective::quadrature_error(const std::vector<double>& squared_distances, const Control& u) const {
  constexpr int points = 3;
  const step::TimeGrid& grid = weights_.grid();
  const int steps = grid.steps();
  if (steps < points)
    return 0;
  // Σ τ_k² times the change of f' over step k, from values f_i at ascending times x_i. Slopes between two of
  // these are those in the middle; f' is linear between middles and beyond them.
  const auto changes = [&](const std::vector<double>& x, const std::vector<double>& f) {
    std::size_t i = 0;
    const auto slope = [&](std::size_t j) { return (f[j + 1] - f[j]) / (x[j + 1] - x[j]); };
    const auto middle = [&](std::size_t j) { return (x[j] + x[j + 1]) / 2; };
    const auto derivative = [&](double t) {
      while (i + points < x.size() && middle(i + 1) < t)
        ++i;
      const double part = (t - middle(i)) / (middle(i + 1) - middle(i));
      return (1 - part) * slope(i) + part * slope(i + 1);
    };
    double sum = 0;
    for (auto [k, before] = std::pair(1, derivative(0)); k <= steps; ++k) {
      const double now = derivative(grid.time(k)), tau = grid.length(k);
      sum += tau * tau * (now - std::exchange(before, now));
    }
    return sum;
  };
  double error = 0;
  if (weights_.tracking() > 0) {
    std::vector<double> times, values;
    for (int k = 0; k <= steps; ++k) {
      times.push_back(grid.time(k));
      values.push_back(squared_distances[k] / 2);
    }
    error -= weights_.tracking() / 12 * changes(times, values);
  }
  if (alpha() > 0 && u.count() == steps)
    error += alpha() / 24 * variation(u);
  return error;
}

double Objective::variation(const Control& u) const {
  const step::TimeGrid& grid = weights_.grid();
  const int steps = grid.steps();
  Control change(controls_.size(), 1);
  double sum = 0;
  for (int k = 1; k < steps; ++k) {
    const double tau = grid.length(k), later = grid.length(k + 1), between = (tau + later) / 2;
    for (std::size_t i = 0; i < change.at(1).size(); ++i)
      change.at(1)[i] = u.at(k + 1)[i] - u.at(k)[i];
    // From middle to middle, and on to the ends beyond the first and the last one.
    const double first = k == 1 ? 2 : 1, last = k + 1 == steps ? 2 : 1,
                 squares = (first * std::pow(tau, 3) + last * std::pow(later, 3)) / 2;
    sum += squares * controls_.product_at(1, change, change) / (between * between);
  }
  return sum;
}

void Objective::add_weighted(int k, Vec y, Vec less, step::StateDual sum) const {
  // ∂J/∂y_k = w_k W (y_k − y_d): the density w_k (y_k − y_d), or its product with the matrix of the set
  const Vec out = !observed_.whole() ? Vec(work_) : sum.density;
  if (!observed_.whole())
    check(VecZeroEntries(out));
  if (less)
    check(VecAXPBYPCZ(out, weight(k), -weight(k), 1, y, less));
  else
    check(VecAXPY(out, weight(k), y));
  if (!observed_.whole())
    check(MatMultAdd(observed_.product(), work_, sum.vector, sum.vector));
}

} // namespace signorini::control
