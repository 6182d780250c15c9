#pragma once
#include "adjoint/sweep.h"
#include "base/progress.h"
#include "base/timers.h"
#include "control/objective.h"
#include "forward/trajectory.h"
#include <memory>

namespace signorini::control {

/// u ↦ J(S(u), u) with S the solution operator of the contact problem: value, gradient, Hessian product. The
/// problem keeps the trajectory of the current control and that of a trial, in `storage`; a rejected trial changes
/// nothing. All members collective; those that compute throw WriteFailure if the storage does.
class ReducedProblem {
public:
  using Vector = Control;

  /// Those made so far; a linearised one counts as a forward one.
  struct Sweeps {
    int forward = 0, adjoint = 0;
  };

  /// The references must outlive this object. `load` is the load without the control, null if there is none.
  ReducedProblem(const forward::Stepper& stepper, const ControlSpace& controls, const Objective& objective,
                 const forward::Initial& initial, const forward::Load* load, const forward::Storage& storage,
                 Timers& timers);

  /// J(u) by a forward sweep; u becomes the trial. Throws Interrupted, SolverFailure.
  double value(const Control& u);

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

  /// S'(u) d: shows the linearised states δy_1…δy_N at the current control, active sets frozen. Throws Interrupted.
  void linearised(const Control& d, const std::function<void(int k, Vec dy)>& visit);

  /// J'(u; d), exact where contact is weak too: by the linearised motion in which weak candidates may open, and as ⟨g, d⟩ with
  /// the gradient g of the piece of J that lies that way, whose contact has the sets that then stay closed. Both are
  /// the same; where no contact is weak g is the gradient. Throws Interrupted.
  struct OneSided {
    double by_motion = 0, by_gradient = 0;
    double size = 0; ///< what by_motion would be if nothing cancelled, against which rounding is to be seen
    std::vector<contact::ContactSets> contact;
  };
  OneSided one_sided_slope(const Control& d);

  /// S'(u)* w for duals w_1…w_N of the states, as Riesz representative in L2(0,T; L2).
  Control adjoint(const forward::DualAtStep& dual);

  [[nodiscard]] double inner(const Control& u, const Control& w) const { return controls_.metric(u, w); }
  [[nodiscard]] Control dual(const Control& u) const { return controls_.dual(u); }
  [[nodiscard]] std::vector<double> pairings(const Control& dual, std::span<const std::shared_ptr<const Control>> w) const {
    return controls_.pairings(dual, w);
  }
  void project(Control& u) const { controls_.project(u); }
  void hold(Control& w, const Control& u, const Control& d) const { controls_.hold(w, u, d); }

  [[nodiscard]] const Control& control() const { return current_->u; }
  [[nodiscard]] const Value& value() const { return current_->value; }
  [[nodiscard]] const forward::Trajectory& trajectory() const { return current_->trajectory; }
  [[nodiscard]] const forward::Trajectory& trial_trajectory() const { return trial_->trajectory; }
  /// ‖y_k − y_d,k‖² of the current control (N + 1), as Objective::observe().
  [[nodiscard]] const std::vector<double>& squared_distances() const { return current_->squared_distances; }
  /// Shows p_N … p_1 of the current control, each valid during the call, by one more adjoint sweep.
  void adjoint_states(const std::function<void(int k, Vec p)>& visit) const;
  [[nodiscard]] Sweeps sweeps() const { return sweeps_; }
  /// Goes on counting from there.
  void count_from(Sweeps sweeps) { sweeps_ = sweeps; }
  /// All that acts with the current control; valid until another is accepted.
  [[nodiscard]] forward::ForceAtStep load() const { return load(*current_); }
  [[nodiscard]] const ControlSpace& controls() const { return controls_; }
  [[nodiscard]] const Objective& objective() const { return objective_; }
  [[nodiscard]] const forward::Stepper& stepper() const { return stepper_; }

private:
  struct Point {
    Point(const ControlSpace& controls, const forward::Stepper& stepper, const forward::Initial& initial, const forward::Storage& storage)
        : u(controls.zero()), force(controls, u), trajectory(stepper, initial, controls.steps(), storage) {}

    Control u;
    ControlForce force; ///< of u
    forward::Trajectory trajectory;
    std::vector<double> squared_distances;
    Value value;
  };

  [[nodiscard]] std::unique_ptr<Point> point() const;
  [[nodiscard]] forward::ForceAtStep load(const Point& at) const { return {stepper_.space(), {load_, &at.force}}; }
  using Step = std::function<void(int k, Vec y0, Vec v0, forward::NodalForce load, Vec y1, Vec v1)>;
  /// Hands a march over S'(u) d, by these steps or those on the current contact, to `use`.
  void march_linearised(const Control& d, const Step& step, const std::function<void(forward::March& march)>& use);
  void march_linearised(const Control& d, const std::function<void(forward::March& march)>& use);
  /// Goes through it once.
  void through_linearised(forward::March& march, const std::function<void(const forward::State& state)>& visit);

  /// scale u + S'(at)* w as Riesz representative in L2(0,T; L2).
  Control riesz(const std::vector<contact::ContactSets>& contact, const forward::DualAtStep& dual, double scale, const Control& u);
  Control l2_gradient(const Point& at);

  const forward::Stepper& stepper_;
  const ControlSpace& controls_;
  const Objective& objective_;
  const forward::Initial& initial_;
  const forward::Load* load_; ///< null without one
  const forward::Storage& storage_;
  Timers& timers_;
  std::unique_ptr<Point> current_, trial_; ///< where they are they stay: forces refer to their controls
  Sweeps sweeps_;
};

} // namespace signorini::control
