// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "adjoint/sweep.h"
#include "base/progress.h"
#include "base/timers.h"
#include "control/control.h"
#include "control/control_space.h"
#include "control/misfit.h"
#include "control/objective.h"
#include "trajectory/trajectory.h"
#include <memory>
#include <optional>

namespace signorini::control {

/// The parts of a motion for given values of a scene's parameters. Null members are absent.
struct Model {
  const step::Stepper* stepper;
  const step::State* initial;
  const trajectory::StateStoreFactory* storage; ///< storage of controls' motions
  const step::Load* load = nullptr;             ///< the scene's loads, without a control
  const step::Load* given = nullptr;     ///< force of the scene's own control; acts where none is sought
  Measurements* measurements = nullptr;  ///< with parameters
  step::ParameterRates* rates = nullptr; ///< with parameters
  std::shared_ptr<const void> parts{};   ///< owns all of these, or some
};

/// The reduced objective (u, x) ↦ J(S(u, x), u, x), S being the solution operator of the contact problem:
/// value, gradient, Hessian product (docs/method.md sections 4 and 9). A search varies a control u, the
/// parameters x of a scene on their scales, or both: J is the control's objective, the misfit of the
/// measurements, or their sum. Keeps the trajectories of the current point and of a trial; a rejected trial
/// changes nothing. With parameters every trial has its own model and factor. All members collective; those
/// that compute throw WriteFailure if the storage of states does.
class ReducedProblem {
public:
  using Vector = Variables;
  using Compact = CompactVariables;
  using AdjointObserver = adjoint::AdjointObserver;

  /// Numbers of sweeps so far; a linearised one counts as a forward one.
  struct Sweeps {
    int forward = 0, adjoint = 0;
  };

  /// Makes the model for parameters x, whose measurements have `columns` columns. Throws UserError if the
  /// scene is not valid at x.
  using ModelAt =
      std::function<Model(std::span<const double> x, std::size_t columns, trajectory::Stops stops)>;

  /// Creates the problem of a control. The references must outlive this object, in the next one too.
  ReducedProblem(const Model& model, const ControlSpace& controls, const Objective& objective,
                 Timers& timers);
  /// Creates the problem of parameters and, unless null, of a control with its objective.
  ReducedProblem(ModelAt models, const Misfit& misfit, const ControlSpace* controls,
                 const Objective* objective, Timers& timers);

  /// Makes v the trial, by a forward sweep. Throws Interrupted, SolverFailure; with parameters also if the
  /// scene is not valid at v or one of them is farther from the current point than a step may go.
  void simulate(const Variables& v);
  /// Computes J at v, which becomes the trial as in simulate().
  [[nodiscard]] double value(const Variables& v);

  /// Makes the trial the current point.
  void accept();

  /// The gradient by the control at the current point, as Riesz representative in L2(0,T; L2) by one adjoint
  /// sweep: g_k = α u_k + (τ s/2) p_k where the control acts.
  Control l2_gradient();
  /// Derivatives dJ/dx by the parameters at the current point.
  std::vector<double> gradient_by_parameters();

  /// The gradient as Riesz representative by inner().
  Variables gradient();
  /// The gradient at the trial.
  Variables trial_gradient();

  /// Hessian product H d at the current control, active sets frozen, as Riesz representative in L2(0,T; L2):
  /// one linearised and one adjoint sweep. Not with parameters. Throws Interrupted.
  Control l2_hessian_product(const Control& d);
  /// The Hessian product as Riesz representative by inner(). With parameters it is a difference of gradients,
  /// to about five digits if no active set changes within 1e-5 of the point.
  Variables hessian_product(const Variables& d);

  /// Computes r and ∂r/∂x of the misfit at v, by a motion with one linearised motion for each parameter.
  /// Throws UserError if the scene is not valid there, SolverFailure, Interrupted.
  [[nodiscard]] optimize::LeastSquares least_squares(const Variables& v,
                                                     trajectory::Stops stops = trajectory::Stops::obeyed);
  /// Sets the weights of parameters in inner() at a first guess, and makes that the current point. A change
  /// of x_j is then as long as one of the control along which J has the same curvature. Without a call the
  /// weights are 1.
  void weigh_parameters(const Variables& guess);

  /// Computes S'(u) d: passes the linearised states δy_1…δy_N at the current control, active sets frozen, to
  /// `visit`. Throws Interrupted.
  void linearised(const Control& d, const std::function<void(int k, Vec dy)>& visit);

  /// The one-sided derivative J'(u; d), exact at weak contact too (docs/method.md section 4), computed twice.
  /// One value is that of the linearised motion in which weak candidates may open. The other is ⟨g, d⟩ with
  /// the gradient g of the selection of J in the direction d, by adjoint steps on the sets C_k that then stay
  /// closed. They agree up to rounding; without weak contact g is the gradient. Throws Interrupted.
  struct OneSided {
    petsc::Pairing by_motion{};
    double by_gradient = 0;
    std::vector<contact::ContactLinearisation> contact{}; ///< with C_k as active sets
  };
  OneSided one_sided_slope(const Control& d);

  /// Computes S'(u)* w for duals w_1…w_N of the states, as Riesz representative in L2(0,T; L2).
  Control adjoint(const step::DualAtStep& dual);

  [[nodiscard]] double inner(const Variables& v, const Variables& w) const;
  [[nodiscard]] Variables dual(const Variables& v) const;
  [[nodiscard]] std::vector<double> pairings(std::span<const Variables> duals,
                                             std::span<const Compact> w) const;
  [[nodiscard]] bool bounded() const;
  void project(Variables& v) const;
  void zero_blocked(Variables& w, const Variables& v, const Variables& d) const;

  /// The current variables of the search.
  [[nodiscard]] const Variables& variables() const { return current_->v; }
  [[nodiscard]] const Control& control() const { return current_->v.u; }
  [[nodiscard]] const ObjectiveValue& value() const { return current_->value; }
  [[nodiscard]] const trajectory::Trajectory& trajectory() const { return current_->trajectory; }
  [[nodiscard]] const trajectory::Trajectory& trial_trajectory() const { return trial_->trajectory; }
  /// Squared distances ‖y_k − y_d,k‖² of the current control (N + 1), as Objective::observe().
  [[nodiscard]] const std::vector<double>& squared_distances() const { return current_->squared_distances; }
  /// Residuals of the misfit at the trial.
  [[nodiscard]] const std::vector<double>& trial_residuals() const { return trial_->residuals; }
  /// Passes p_N … p_1 of the current point to `visit`, each valid during the call, by one more adjoint sweep.
  void adjoint_states(const AdjointObserver& visit);
  [[nodiscard]] Sweeps sweeps() const { return sweeps_; }
  /// Sets the counters, when a search is resumed.
  void count_from(Sweeps sweeps) { sweeps_ = sweeps; }
  /// The forces of the loads and the current control; valid until another point is accepted.
  [[nodiscard]] step::ForceAtStep load() const { return load(*current_); }
  [[nodiscard]] const ControlSpace& controls() const { return *controls_; }
  [[nodiscard]] const Objective& objective() const { return *objective_; }
  /// The stepper of the current point.
  [[nodiscard]] const step::Stepper& stepper() const { return *current_->model.stepper; }

private:
  /// A point with its model, its motion and J.
  struct Evaluation {
    Evaluation(Variables at, const ControlSpace* controls, Model with, bool whole)
        : v(std::move(at)), model(std::move(with)),
          trajectory(*model.stepper, *model.initial, *model.storage, whole) {
      if (controls)
        force.emplace(*controls, v.u);
    }
    Evaluation(const Evaluation&) = delete; // force refers to v
    Evaluation& operator=(const Evaluation&) = delete;

    Variables v;
    Model model;
    std::optional<ControlForce> force; ///< force of v.u
    trajectory::Trajectory trajectory;
    std::vector<double> squared_distances, residuals;
    ObjectiveValue value;
    std::optional<Variables> gradient; ///< with parameters, once computed
  };

  /// Creates a point with a model of its own. Throws SolverFailure if the scene is not valid at v.
  [[nodiscard]] std::unique_ptr<Evaluation> evaluation(const Variables& v) const;
  /// Computes the motion of a point, and J.
  void run(Evaluation& at);
  [[nodiscard]] static step::ForceAtStep load(const Model& model, const ControlForce* force);
  [[nodiscard]] static step::ForceAtStep load(const Evaluation& at) {
    return load(at.model, at.force ? &*at.force : nullptr);
  }
  /// The gradient: by the control its Riesz representative in L2(0,T; L2), by parameters dJ/dx.
  Variables derivative(Evaluation& at);
  /// Computes derivative() without timing or counting it.
  Variables swept(Evaluation& at, const AdjointObserver& visit);
  /// The gradient by inner().
  Variables gradient(Evaluation& at);

  using Step = std::function<void(int k, const step::LinearisedStep& step)>;
  class LinearisedRun;
  /// Returns steps linearised on the current contact.
  [[nodiscard]] Step on_current_contact();

  /// Computes scale u + S'* w as Riesz representative in L2(0,T; L2): duals w are pulled back by S'
  /// linearised on `contact`.
  Control pull_back(const std::vector<contact::ContactLinearisation>& contact, const step::DualAtStep& dual,
                    double scale, const Control& u);
  /// Computes pull_back() without timing or counting it.
  Control swept(const std::vector<contact::ContactLinearisation>& contact, const step::DualAtStep& dual,
                double scale, const Control& u, const AdjointObserver& visit);

  ModelAt models_; ///< empty without parameters
  const Misfit* misfit_ = nullptr;
  const ControlSpace* controls_;
  const Objective* objective_;
  Timers& timers_;
  std::vector<double> weights_;                  ///< weights of the parameters in inner()
  std::optional<step::Stepper::Workspace> work_; ///< for linearised and adjoint steps, without parameters
  std::unique_ptr<Evaluation> current_, trial_;
  Sweeps sweeps_;
};

} // namespace signorini::control
