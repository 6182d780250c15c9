// SPDX-License-Identifier: GPL-3.0-or-later
#include "control/scenario_problem.h"
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace signorini::control {

void ScenarioProblem::each(const std::function<void(std::size_t s)>& action, const Mean* mean) {
  const auto timer = timers_.time("scenarios");
  std::vector<std::function<void()>> tasks;
  for (std::size_t s = 0; s <= others_.size(); ++s)
    if (!mean || mean->shares[s] > 0)
      tasks.emplace_back([&action, s] { action(s); });
  run_tasks_(tasks);
}

void ScenarioProblem::simulate(const Variables& v) {
  each([&](std::size_t s) { s == 0 ? ReducedProblem::simulate(v) : others_[s - 1]->simulate(v); });
  std::vector<ObjectiveValue> values{ReducedProblem::trial_value()};
  for (const ReducedProblem* other : others_)
    values.push_back(other->trial_value());
  double largest = 0, sum = 0; // divided by the largest J_s, since powers overflow
  for (std::size_t s = 0; s < values.size(); ++s)
    if (weights_[s] > 0)
      largest = std::max(largest, values[s].total());
  for (std::size_t s = 0; s < values.size(); ++s)
    if (largest > 0 && weights_[s] > 0)
      sum += weights_[s] * std::pow(values[s].total() / largest, exponent_);
  const double J = largest * std::pow(sum, 1 / exponent_);
  trial_mean_ = {.shares = weights_};
  for (std::size_t s = 0; s < values.size(); ++s) {
    double& share = trial_mean_.shares[s];
    if (J > 0)
      share *= std::pow(values[s].total() / J, exponent_ - 1);
    trial_mean_.value.tracking += share * values[s].tracking;
    trial_mean_.value.terminal += share * values[s].terminal;
    trial_mean_.value.control_cost += share * values[s].control_cost;
  }
}

void ScenarioProblem::accept() {
  ReducedProblem::accept();
  for (ReducedProblem* other : others_)
    other->accept();
  std::swap(current_mean_, trial_mean_);
}

template <class V, class Action>
std::vector<V> ScenarioProblem::parts(const Mean& mean, Action&& action) {
  std::vector<V> all(weights_.size(), V(controls().zero()));
  each([&](std::size_t s) { all[s] = action(s); }, &mean);
  return all;
}

template <class V>
V ScenarioProblem::sum(const Mean& mean, const std::vector<V>& parts) const {
  V sum(controls().zero());
  for (std::size_t s = 0; s < parts.size(); ++s)
    if (mean.shares[s] > 0)
      sum.add(mean.shares[s], parts[s]);
  return sum;
}

template <class V>
void ScenarioProblem::add_change_of_shares(const std::vector<V>& gradients, const std::vector<double>& slopes,
                                           V& product) const {
  // (p − 1)/J (Σ_s q_s J/J_s g_s g_sᵀ − g gᵀ) d
  const double J = current_mean_.value.total();
  const std::vector<ObjectiveValue> J_s = values();
  const std::vector<double>& shares = current_mean_.shares;
  double slope = 0;
  for (std::size_t s = 0; s < shares.size(); ++s)
    slope += shares[s] * slopes[s];
  for (std::size_t s = 0; s < shares.size(); ++s)
    if (shares[s] > 0 && J_s[s].total() > 0)
      product.add((exponent_ - 1) * shares[s] * (slopes[s] / J_s[s].total() - slope / J), gradients[s]);
}

Variables ScenarioProblem::sum_of_gradients(Mean& mean, std::vector<Variables> gradients) const {
  Variables g = sum(mean, gradients);
  if (exponent_ != 1)
    mean.gradients = std::move(gradients);
  return g;
}

Variables ScenarioProblem::gradient() {
  return sum_of_gradients(current_mean_, parts<Variables>(current_mean_, [this](std::size_t s) {
                            return s == 0 ? ReducedProblem::gradient() : others_[s - 1]->gradient();
                          }));
}

Variables ScenarioProblem::trial_gradient() {
  return sum_of_gradients(trial_mean_, parts<Variables>(trial_mean_, [this](std::size_t s) {
                            return s == 0 ? ReducedProblem::trial_gradient()
                                          : others_[s - 1]->trial_gradient();
                          }));
}

std::vector<Control> ScenarioProblem::l2_gradients() {
  return parts<Control>(current_mean_, [this](std::size_t s) {
    return s == 0 ? ReducedProblem::l2_gradient() : others_[s - 1]->l2_gradient();
  });
}

Control ScenarioProblem::l2_gradient() { return sum(current_mean_, l2_gradients()); }

Variables ScenarioProblem::hessian_product(const Variables& d) {
  Variables product =
      sum(current_mean_, parts<Variables>(current_mean_, [&](std::size_t s) {
            return s == 0 ? ReducedProblem::hessian_product(d) : others_[s - 1]->hessian_product(d);
          }));
  if (exponent_ == 1)
    return product;
  if (current_mean_.gradients.empty())
    (void)gradient();
  std::vector<double> slopes;
  for (const Variables& g : current_mean_.gradients)
    slopes.push_back(inner(g, d));
  add_change_of_shares(current_mean_.gradients, slopes, product);
  return product;
}

Control ScenarioProblem::l2_hessian_product(const Control& d) {
  Control product =
      sum(current_mean_, parts<Control>(current_mean_, [&](std::size_t s) {
            return s == 0 ? ReducedProblem::l2_hessian_product(d) : others_[s - 1]->l2_hessian_product(d);
          }));
  if (exponent_ == 1)
    return product;
  const std::vector<Control> gradients = l2_gradients();
  std::vector<double> slopes;
  for (const Control& g : gradients)
    slopes.push_back(controls().product(g, d));
  add_change_of_shares(gradients, slopes, product);
  return product;
}

ScenarioProblem::OneSided ScenarioProblem::one_sided_slope(const Control& d) {
  std::vector<OneSided> slopes(weights_.size());
  each([&](std::size_t s) {
    slopes[s] = s == 0 ? ReducedProblem::one_sided_slope(d) : others_[s - 1]->one_sided_slope(d);
  });
  OneSided all;
  for (std::size_t s = 0; s < slopes.size(); ++s) {
    const double share = current_mean_.shares[s];
    all.by_motion.value += share * slopes[s].by_motion.value;
    all.by_motion.size += share * slopes[s].by_motion.size;
    all.by_gradient += share * slopes[s].by_gradient;
    std::ranges::move(slopes[s].contact, std::back_inserter(all.contact));
  }
  return all;
}

ScenarioProblem::ContactHistory ScenarioProblem::contact() const {
  ContactHistory all = ReducedProblem::contact();
  for (const ReducedProblem* other : others_)
    std::ranges::move(other->contact(), std::back_inserter(all));
  return all;
}

ScenarioProblem::ContactHistory ScenarioProblem::trial_contact() const {
  ContactHistory all = ReducedProblem::trial_contact();
  for (const ReducedProblem* other : others_)
    std::ranges::move(other->trial_contact(), std::back_inserter(all));
  return all;
}

ScenarioProblem::Sweeps ScenarioProblem::sweeps() const {
  Sweeps all = ReducedProblem::sweeps();
  for (const ReducedProblem* other : others_) {
    all.forward += other->sweeps().forward;
    all.adjoint += other->sweeps().adjoint;
  }
  return all;
}

void ScenarioProblem::restore_sweeps(Sweeps sweeps) {
  ReducedProblem::restore_sweeps(sweeps);
  for (ReducedProblem* other : others_)
    other->restore_sweeps({});
}

std::vector<ObjectiveValue> ScenarioProblem::values() const {
  std::vector<ObjectiveValue> all{ReducedProblem::value()};
  for (const ReducedProblem* other : others_)
    all.push_back(other->value());
  return all;
}

} // namespace signorini::control
