// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "adjoint/sweep.h"
#include "base/progress.h"
#include "base/timers.h"
#include "control/control_force.h"
#include "control/objective.h"
#include "forward/trajectory.h"
#include <memory>

namespace signorini::control {

/// The reduced objective u ↦ J(S(u), u), S being the solution operator of the contact problem: value,
/// gradient, Hessian product (docs/method.md section 4). Keeps the trajectories of the current control and of
/// a trial, in `storage`; a rejected trial changes nothing. All members collective; those that compute throw
/// WriteFailure if the storage does.
class ReducedProblem {
public:
  using Vector = Control;
  using Compact = CompactControl;

  /// Numbers of sweeps so far; a linearised one counts as a forward one.
  struct Sweeps {
    int forward = 0, adjoint = 0;
  };

  /// The references must outlive this object. `load` is the load without the control, null if there is none.
  ReducedProblem(const forward::Stepper& stepper, const ControlSpace& controls, const Objective& objective,
                 const forward::State& initial, const forward::Load* load,
                 const forward::StateStoreFactory& storage, Timers& timers);

  /// Makes u the trial, by a forward sweep. Throws Interrupted, SolverFailure.
  void simulate(const Control& u);
  /// The same; J(u).
  [[nodiscard]] double value(const Control& u);

  /// The trial becomes the current control.
  void accept();

  /// The gradient at the current control, as Riesz representative in L2(0,T; L2) by one adjoint sweep:
  /// g_k = α u_k + (τ s/2) p_k where the control acts.
  Control l2_gradient();

  /// The gradient as Riesz representative in the optimizer's metric.
  Control gradient();
  /// The same at the trial.
  Control trial_gradient();

  /// Hessian product H d at the current control, active sets frozen, as Riesz representative in L2(0,T; L2):
  /// one linearised and one adjoint sweep. Throws Interrupted.
  Control l2_hessian_product(const Control& d);
  /// The Hessian product as Riesz representative in the optimizer's metric.
  Control hessian_product(const Control& d);

  /// S'(u) d: shows the linearised states δy_1…δy_N at the current control, active sets frozen. Throws
  /// Interrupted.
  void linearised(const Control& d, const std::function<void(int k, Vec dy)>& visit);

  /// The one-sided derivative J'(u; d), exact at weak contact too (docs/method.md section 4), computed twice:
  /// by the linearised motion in which weak candidates may open, and as ⟨g, d⟩ with the gradient g of the
  /// piece of J in the direction d, which slides on the sets C_k that then stay closed. They agree up to
  /// rounding; without weak contact g is the gradient. Throws Interrupted.
  struct OneSided {
    petsc::Pairing by_motion;
    double by_gradient = 0;
    std::vector<contact::ContactLinearisation> contact; ///< with C_k as active sets
  };
  OneSided one_sided_slope(const Control& d);

  /// S'(u)* w for duals w_1…w_N of the states, as Riesz representative in L2(0,T; L2).
  Control adjoint(const forward::DualAtStep& dual);

  [[nodiscard]] double inner(const Control& u, const Control& w) const { return controls_.inner(u, w); }
  [[nodiscard]] Control dual(const Control& u) const { return controls_.dual(u); }
  [[nodiscard]] std::vector<double> pairings(std::span<const Control> duals,
                                             std::span<const Compact> w) const {
    return controls_.pairings(duals, w);
  }
  [[nodiscard]] bool bounded() const { return controls_.bounded(); }
  void project(Control& u) const { controls_.project(u); }
  void zero_blocked(Control& w, const Control& u, const Control& d) const { controls_.zero_blocked(w, u, d); }

  [[nodiscard]] const Control& control() const { return current_->u; }
  [[nodiscard]] const Value& value() const { return current_->value; }
  [[nodiscard]] const forward::Trajectory& trajectory() const { return current_->trajectory; }
  [[nodiscard]] const forward::Trajectory& trial_trajectory() const { return trial_->trajectory; }
  /// ‖y_k − y_d,k‖² of the current control (N + 1), as Objective::observe().
  [[nodiscard]] const std::vector<double>& squared_distances() const { return current_->squared_distances; }
  /// Shows p_N … p_1 of the current control, each valid during the call, by one more adjoint sweep.
  void adjoint_states(const std::function<void(int k, Vec p)>& visit);
  [[nodiscard]] Sweeps sweeps() const { return sweeps_; }
  /// Sets the counters, when a search is resumed.
  void count_from(Sweeps sweeps) { sweeps_ = sweeps; }
  /// The forces of the loads and the current control; valid until another is accepted.
  [[nodiscard]] forward::ForceAtStep load() const { return load(*current_); }
  [[nodiscard]] const ControlSpace& controls() const { return controls_; }
  [[nodiscard]] const Objective& objective() const { return objective_; }
  [[nodiscard]] const forward::Stepper& stepper() const { return stepper_; }

private:
  struct Point {
    Point(const ControlSpace& controls, const forward::Stepper& stepper, const forward::State& initial,
          const forward::StateStoreFactory& storage)
        : u(controls.zero()), force(controls, u), trajectory(stepper, initial, storage) {}

    Control u;
    ControlForce force; ///< of u
    forward::Trajectory trajectory;
    std::vector<double> squared_distances;
    Value value;
  };

  [[nodiscard]] std::unique_ptr<Point> point() const;
  [[nodiscard]] forward::ForceAtStep load(const Point& at) const {
    return {stepper_.space(), {load_, &at.force}};
  }
  using Step = std::function<void(int k, const forward::LinearisedStep& step)>;
  /// Calls `use` with an integrator of S'(u) d that makes these steps or, without them, those linearised on
  /// the current contact.
  void integrate_linearised(const Control& d, const Step& step,
                            const std::function<void(forward::TimeIntegrator& integrator)>& use);
  void integrate_linearised(const Control& d,
                            const std::function<void(forward::TimeIntegrator& integrator)>& use);
  /// Makes all of its steps once and shows the states 0…N. Throws Interrupted.
  void make_linearised_steps(forward::TimeIntegrator& integrator,
                             const std::function<void(const forward::Checkpoint& now)>& visit);

  /// scale u + S'* w, duals w pulled back by S' linearised on `contact`, as Riesz representative in
  /// L2(0,T; L2).
  Control pull_back(const std::vector<contact::ContactLinearisation>& contact,
                    const forward::DualAtStep& dual, double scale, const Control& u);
  Control l2_gradient(const Point& at);

  const forward::Stepper& stepper_;
  const ControlSpace& controls_;
  const Objective& objective_;
  const forward::State& initial_;
  const forward::Load* load_; ///< null without one
  const forward::StateStoreFactory& storage_;
  Timers& timers_;
  forward::Stepper::Workspace work_;       ///< of linearised and adjoint steps
  std::unique_ptr<Point> current_, trial_; ///< never moved: forces refer to their controls
  Sweeps sweeps_;
};

} // namespace signorini::control
