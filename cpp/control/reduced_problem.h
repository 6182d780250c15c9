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

/// Parts from which motions are computed for given values of a scene's parameters. Members that are absent
/// are null.
struct Model {
  const step::Stepper* stepper;
  const step::State* initial;
  const trajectory::StateStoreFactory* storage; ///< makes the stores for motions
  const step::Load* load = nullptr;             ///< the scene's loads, without a control
  const step::Load* given = nullptr;     ///< force of the scene's control; acts if no control is sought
  Measurements* measurements = nullptr;  ///< only if parameters are sought
  step::ParameterRates* rates = nullptr; ///< only if parameters are sought
  std::shared_ptr<const void> parts{};   ///< owns objects that the other members refer to; may be null
};

/// Reduced objective (u, x) ↦ J(S(u, x), u, x), S being the solution operator of the contact problem: value,
/// gradient and Hessian product (docs/method.md sections 4 and 9). A search varies a control u, the
/// parameters x of a scene (θ or log θ), or both. J is the control's objective, the misfit of the
/// measurements, or their sum. Stores the trajectories of the current point and of a trial; a rejected trial
/// changes nothing. With parameters, every trial has its own model and factorisation. Virtual members are
/// those of J over several scenarios (ScenarioProblem); the others concern the motion of the scene itself.
/// All members are collective; members that compute throw WriteFailure if storing states fails.
class ReducedProblem {
public:
  using Vector = Variables;
  using Compact = CompactVariables;
  using AdjointObserver = adjoint::AdjointObserver;

  /// Numbers of sweeps so far; a linearised sweep counts as a forward one.
  struct Sweeps {
    int forward = 0, adjoint = 0;
  };

  /// Function that creates the model for parameters x, with `columns` columns of values in Measurements.
  /// Throws UserError if the scene is not valid at x.
  using ModelAt =
      std::function<Model(std::span<const double> x, std::size_t columns, trajectory::Stops stops)>;

  /// Creates the problem of a control without parameters. The references must outlive this object.
  ReducedProblem(const Model& model, const ControlSpace& controls, const Objective& objective,
                 Timers& timers);
  /// Creates the problem of parameters and, unless `controls` is null, of a control with its objective. The
  /// references must outlive this object.
  ReducedProblem(ModelAt models, const Misfit& misfit, const ControlSpace* controls,
                 const Objective* objective, Timers& timers);
  virtual ~ReducedProblem() = default;
  ReducedProblem(const ReducedProblem&) = delete;
  ReducedProblem& operator=(const ReducedProblem&) = delete;

  /// Makes v the trial by computing its motion, a forward sweep. Throws Interrupted, SolverFailure. With
  /// parameters, SolverFailure is also thrown if the scene is not valid at v, or if a parameter differs from
  /// the current point by more than one step of the search may change it.
  virtual void simulate(const Variables& v);
  /// Computes J at v, which becomes the trial as in simulate().
  [[nodiscard]] double value(const Variables& v) {
    simulate(v);
    return trial_value().total();
  }

  /// Makes the trial the current point.
  virtual void accept();

  /// Returns the gradient by the control at the current point, as Riesz representative in L2(0,T; L2), by one
  /// adjoint sweep: g_k = α u_k + (τ s/2) p_k where the control acts.
  virtual Control l2_gradient();
  /// Returns the derivatives dJ/dx by the parameters at the current point.
  std::vector<double> gradient_by_parameters();

  /// Returns the gradient at the current point, as Riesz representative in inner().
  virtual Variables gradient();
  /// Returns the gradient at the trial, as Riesz representative in inner().
  virtual Variables trial_gradient();

  /// Returns the Hessian product H d at the current control with frozen active sets, as Riesz representative
  /// in L2(0,T; L2), by one linearised and one adjoint sweep. Not available with parameters. Throws
  /// Interrupted.
  virtual Control l2_hessian_product(const Control& d);
  /// Returns the Hessian product H d at the current point, as Riesz representative in inner(). With
  /// parameters it is a difference quotient of two gradients. Their distance is 1e-5 times the norm of the
  /// current point in inner(), or 1e-5 at zero. About five digits are correct if no active set changes over
  /// this distance.
  virtual Variables hessian_product(const Variables& d);

  /// Computes the residuals r and ∂r/∂x of the misfit at v, by a motion with one linearised motion for each
  /// parameter. Throws UserError if the scene is not valid at v, SolverFailure, Interrupted.
  [[nodiscard]] optimize::LeastSquares least_squares(const Variables& v,
                                                     trajectory::Stops stops = trajectory::Stops::obeyed);
  /// Sets the weights of parameters in inner() at a first guess, and makes that guess the current point. The
  /// misfit then has the same curvature along each x_j, per unit of squared length in inner(), as J has along
  /// its steepest descent by the control alone. The weights are 1 before the first call.
  void weigh_parameters(const Variables& guess);

  /// Computes S'(u) d: passes the linearised displacements δy_1…δy_N at the current control, with frozen
  /// active sets, to `visit`. Throws Interrupted.
  void linearised(const Control& d, const std::function<void(int k, Vec dy)>& visit);

  /// One-sided derivative J'(u; d), exact at weak contact too (docs/method.md section 4), computed in two
  /// ways. by_motion: along the linearised motion in which weakly active candidates may open. by_gradient:
  /// ⟨g, d⟩ with the gradient g of the selection of J in the direction d, by adjoint steps on the sets C_k of
  /// candidates that stay closed in that motion. The two values agree up to rounding; without weak contact g
  /// is the gradient.
  struct OneSided {
    petsc::Pairing by_motion{};
    double by_gradient = 0;
    std::vector<contact::ContactLinearisation> contact{}; ///< as contact(), with C_k as active sets
  };
  /// Computes the one-sided derivative J'(u; d) at the current control u. Throws Interrupted.
  virtual OneSided one_sided_slope(const Control& d);

  /// Returns S'(u)* w for duals w_1…w_N of the states (`dual`), as Riesz representative in L2(0,T; L2).
  Control adjoint(const step::DualAtStep& dual);

  /// Returns the optimizer's product: ControlSpace::inner() plus the weighted product of the parameters.
  [[nodiscard]] double inner(const Variables& v, const Variables& w) const;
  /// Returns the functional inner(v, ·) in the form that pairings() takes.
  [[nodiscard]] Variables dual(const Variables& v) const;
  [[nodiscard]] std::vector<double> pairings(std::span<const Variables> duals,
                                             std::span<const Compact> w) const;
  [[nodiscard]] bool bounded() const;
  void project(Variables& v) const;
  void zero_blocked(Variables& w, const Variables& v, const Variables& d) const;

  /// Returns the variables at the current point.
  [[nodiscard]] const Variables& variables() const { return current_->v; }
  [[nodiscard]] const Control& control() const { return current_->v.u; }
  [[nodiscard]] virtual const ObjectiveValue& value() const { return current_->value; }
  /// Returns the value of J at the trial.
  [[nodiscard]] virtual const ObjectiveValue& trial_value() const { return trial_->value; }
  [[nodiscard]] const trajectory::Trajectory& trajectory() const { return current_->trajectory; }
  [[nodiscard]] const trajectory::Trajectory& trial_trajectory() const { return trial_->trajectory; }
  /// Contact in the steps 0…N of a motion; with scenarios, of one motion after another.
  using ContactHistory = std::vector<contact::ContactLinearisation>;
  /// Returns contact at the current point.
  [[nodiscard]] virtual ContactHistory contact() const { return current_->trajectory.contact(); }
  /// Returns contact at the trial.
  [[nodiscard]] virtual ContactHistory trial_contact() const { return trial_->trajectory.contact(); }
  /// Returns the squared distances ‖y_k − y_d,k‖² at the current point (N + 1), as Objective::observe()
  /// stores them.
  [[nodiscard]] const std::vector<double>& squared_distances() const { return current_->squared_distances; }
  /// Returns the residuals of the misfit at the trial.
  [[nodiscard]] const std::vector<double>& trial_residuals() const { return trial_->residuals; }
  /// Passes the adjoint states p_N … p_1 at the current point to `visit`, each valid during the call. Takes
  /// one more adjoint sweep, which is not counted.
  void adjoint_states(const AdjointObserver& visit);
  /// Returns the numbers of sweeps so far.
  [[nodiscard]] virtual Sweeps sweeps() const { return sweeps_; }
  /// Sets the numbers of sweeps so far, when a search is resumed.
  virtual void restore_sweeps(Sweeps sweeps) { sweeps_ = sweeps; }
  /// Returns the force of the loads and of the current control; valid until another point is accepted.
  [[nodiscard]] step::ForceAtStep load() const { return load(*current_); }
  [[nodiscard]] const ControlSpace& controls() const { return *controls_; }
  [[nodiscard]] const Objective& objective() const { return *objective_; }
  /// Returns the stepper of the current point.
  [[nodiscard]] const step::Stepper& stepper() const { return *current_->model.stepper; }

private:
  /// A point of the search with its model, its motion and the value of J.
  struct Evaluation {
    Evaluation(Variables at, const ControlSpace* controls, Model with, bool whole_states)
        : v(std::move(at)), model(std::move(with)),
          trajectory(*model.stepper, *model.initial, *model.storage, whole_states) {
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
    std::optional<Variables> gradient; ///< gradient in inner(), once computed; empty without parameters
  };

  /// Creates a point with a separate model, for v with parameters. Throws SolverFailure if the scene is not
  /// valid at v.
  [[nodiscard]] std::unique_ptr<Evaluation> evaluation(const Variables& v) const;
  /// Computes the motion and the value of J at a point.
  void run(Evaluation& at);
  [[nodiscard]] static step::ForceAtStep load(const Model& model, const ControlForce* force);
  [[nodiscard]] static step::ForceAtStep load(const Evaluation& at) {
    return load(at.model, at.force ? &*at.force : nullptr);
  }
  /// Returns the gradient at a point: by the control as Riesz representative in L2(0,T; L2), by parameters as
  /// dJ/dx.
  Variables derivative(Evaluation& at);
  /// Does the work of derivative() without timing or counting it, and passes the adjoint states to `visit`
  /// unless it is empty.
  Variables derivative_by_sweep(Evaluation& at, const AdjointObserver& visit);
  /// Returns the gradient at a point, as Riesz representative in inner().
  Variables gradient(Evaluation& at);

  using Step = std::function<void(int k, const step::LinearisedStep& step)>;
  class LinearisedRun;
  /// Returns a function that makes steps linearised on the active sets of the current point.
  [[nodiscard]] Step on_current_contact();

  /// Returns scale u + S'* w as Riesz representative in L2(0,T; L2), with duals w = `dual` of the states and
  /// S' linearised on the active sets of `contact`.
  Control pull_back(const std::vector<contact::ContactLinearisation>& contact, const step::DualAtStep& dual,
                    double scale, const Control& u);
  /// Does the work of pull_back() without timing or counting it, and passes the adjoint states to `visit`
  /// unless it is empty.
  Control pull_back_by_sweep(const std::vector<contact::ContactLinearisation>& contact,
                             const step::DualAtStep& dual, double scale, const Control& u,
                             const AdjointObserver& visit);

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
