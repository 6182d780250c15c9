// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "app/fit/fit_problem.h"
#include "app/fit/joint_vector.h"

namespace signorini {

/// J of a control and of a scene's unknowns together: that of the control's objective and the misfit of the
/// measurements, with the motion of both. Its space is the product of the controls' and of the unknowns',
/// where a change of x_j is as long as one of the control along which J curves as much, both at the guess.
/// Every trial has a step operator of its own. All members collective.
class JointProblem {
public:
  using Vector = JointVector;
  using Compact = CompactJointVector;

  /// `control`: for its controls and objective, at the scene's own values. The references must outlive this
  /// object. Throws UserError, SolverFailure, Interrupted.
  JointProblem(FitProblem& fit, const ControlProblem& control, const Vector& guess, Timers& timers);
  ~JointProblem();
  JointProblem(const JointProblem&) = delete;
  JointProblem& operator=(const JointProblem&) = delete;

  /// Makes v the trial, by a forward sweep. Throws SolverFailure, also where the scene is none with these
  /// unknowns or one of them is farther from the current point than a step may go; Interrupted.
  double value(const Vector& v);
  /// The gradient at the trial, by one adjoint sweep, as Riesz representative by inner().
  Vector trial_gradient();
  /// The trial becomes the current point.
  void accept();
  /// By a difference of gradients: to five digits or so, where no active set changes within 1e-5 of the
  /// point.
  Vector hessian_product(const Vector& d);

  [[nodiscard]] double inner(const Vector& v, const Vector& w) const;
  [[nodiscard]] Vector dual(const Vector& v) const;
  [[nodiscard]] std::vector<double> pairings(std::span<const Vector> duals, std::span<const Compact> w) const;
  [[nodiscard]] bool bounded() const;
  void project(Vector& v) const;
  void zero_blocked(Vector& w, const Vector& v, const Vector& d) const;

  struct Value {
    control::Value control;
    double misfit = 0; ///< ½ Σ of squared residuals, priors included
    [[nodiscard]] double total() const { return control.total() + misfit; }
  };
  /// At the current point.
  [[nodiscard]] const Value& value() const;
  [[nodiscard]] const Vector& vector() const;
  [[nodiscard]] const Problem& problem() const;
  [[nodiscard]] forward::ForceAtStep load() const;
  [[nodiscard]] const forward::Trajectory& trajectory() const;
  /// The same of the trial.
  [[nodiscard]] const forward::Trajectory& trial_trajectory() const;
  /// The current control's force, for a fit with it.
  [[nodiscard]] const forward::Load& force() const;
  /// dJ/dx at the current point, of the unknowns.
  [[nodiscard]] std::vector<double> gradient_by_unknowns();
  /// Shows p_N … p_1 of the current point.
  void adjoint_states(const std::function<void(int k, Vec p)>& visit);

  [[nodiscard]] control::ReducedProblem::Sweeps sweeps() const { return sweeps_; }
  void count_from(control::ReducedProblem::Sweeps sweeps) { sweeps_ = sweeps; }
  [[nodiscard]] const control::ControlSpace& controls() const { return control_.controls; }

private:
  struct Point;
  /// A point with its motion and J. Throws as value() does.
  [[nodiscard]] std::unique_ptr<Point> made(const Vector& v);
  [[nodiscard]] Vector gradient(Point& at, const std::function<void(int k, Vec p)>& visit);
  /// That at the current point.
  const Vector& current_gradient();

  FitProblem& fit_;
  const ControlProblem& control_;
  Timers& timers_;
  std::vector<double> weights_; ///< of the unknowns in inner()
  std::unique_ptr<Point> current_, trial_;
  std::optional<Vector> gradient_, trial_gradient_; ///< where they have been asked for
  control::ReducedProblem::Sweeps sweeps_;
};

} // namespace signorini
