// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/reduced_problem.h"
#include <functional>
#include <span>
#include <vector>

namespace signorini::control {

/// Reduced objective of several scenarios (docs/method.md section 3): J(u) = (Σ_s w_s J_s(u)^p)^(1/p) with
/// the weights w_s, whose sum is 1. The motion of the scene itself is scenario 0. J = Σ_s q_s J_s and ∇J =
/// Σ_s q_s ∇J_s with the shares q_s = w_s (J_s/J)^(p−1); shares of 0 cost no adjoint sweep. All members are
/// collective.
class ScenarioProblem final : public ReducedProblem {
public:
  /// Function that runs tasks, one for each scenario, with common or separate solves.
  using RunTasks = std::function<void(const std::vector<std::function<void()>>& tasks)>;

  /// Creates the problem. `model`, `objective`: of the scene itself. `others`: of the other scenarios, for
  /// the same control space. `weights`: w_s of the scene itself and of the others. The references must
  /// outlive this object.
  ScenarioProblem(const Model& model, const ControlSpace& controls, const Objective& objective,
                  Timers& timers, std::vector<ReducedProblem*> others, std::vector<double> weights,
                  double exponent, RunTasks run_tasks)
      : ReducedProblem(model, controls, objective, timers), timers_(timers), others_(std::move(others)),
        weights_(std::move(weights)), exponent_(exponent), run_tasks_(std::move(run_tasks)) {}

  void simulate(const Variables& v) override;
  void accept() override;
  Control l2_gradient() override;
  Variables gradient() override;
  Variables trial_gradient() override;
  Control l2_hessian_product(const Control& d) override;
  Variables hessian_product(const Variables& d) override;
  OneSided one_sided_slope(const Control& d) override;
  [[nodiscard]] const ObjectiveValue& value() const override { return current_mean_.value; }
  [[nodiscard]] const ObjectiveValue& trial_value() const override { return trial_mean_.value; }
  [[nodiscard]] ContactHistory contact() const override;
  [[nodiscard]] ContactHistory trial_contact() const override;
  [[nodiscard]] Sweeps sweeps() const override;
  void restore_sweeps(Sweeps sweeps) override;

  /// Returns J_s at the current point, of the scene itself and of the others.
  [[nodiscard]] std::vector<ObjectiveValue> values() const;
  /// Returns the weights w_s of the scene itself and of the others.
  [[nodiscard]] std::span<const double> weights() const { return weights_; }
  /// Returns the shares q_s at the current point.
  [[nodiscard]] std::span<const double> shares() const { return current_mean_.shares; }

private:
  /// J and its derivative at a point.
  struct Mean {
    ObjectiveValue value{};
    std::vector<double> shares{};
    std::vector<Variables>
        gradients{}; ///< of all J_s in inner(), once computed; only if the exponent is not 1
  };

  /// Runs `action(s)` for all scenarios, or for those with a share if `mean` is given.
  void each(const std::function<void(std::size_t s)>& action, const Mean* mean = nullptr);
  /// Returns the results of `action(s)` for all scenarios with a share; zero for others.
  template <class V, class Action>
  std::vector<V> parts(const Mean& mean, Action&& action);
  /// Returns Σ_s q_s v_s.
  template <class V>
  [[nodiscard]] V sum(const Mean& mean, const std::vector<V>& parts) const;
  /// Returns ∇J_s of all scenarios with a share, as Riesz representatives in L2(0,T; L2).
  std::vector<Control> l2_gradients();
  /// Returns the gradient in inner() from those of the scenarios, which `mean` keeps if the exponent is
  /// not 1.
  Variables sum_of_gradients(Mean& mean, std::vector<Variables> gradients) const;
  /// Adds the part of the Hessian product H d that the change of the shares along d contributes. `gradients`:
  /// ∇J_s; `slopes`: J_s'(u) d.
  template <class V>
  void add_change_of_shares(const std::vector<V>& gradients, const std::vector<double>& slopes,
                            V& product) const;

  Timers& timers_;
  std::vector<ReducedProblem*> others_;
  std::vector<double> weights_;
  double exponent_;
  RunTasks run_tasks_;
  Mean current_mean_, trial_mean_;
};

} // namespace signorini::control
