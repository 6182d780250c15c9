// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/fit/joint_problem.h"
#include "base/error.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <utility>

namespace signorini {

JointVector::JointVector(const CompactJointVector& compact) : u(compact.u), x(compact.x) {}

std::vector<control::CompactControl> controls_of(std::span<const CompactJointVector> v) {
  std::vector<control::CompactControl> controls;
  for (const CompactJointVector& one : v)
    controls.push_back(one.u);
  return controls;
}

void JointVector::add(std::span<const double> a, std::span<const CompactJointVector> v) {
  u.add(a, controls_of(v));
  for (std::size_t i = 0; i < v.size(); ++i)
    axpy(a[i], v[i].x, x);
}

void CompactJointVector::combine(std::vector<CompactJointVector>& v,
                                 const std::vector<std::vector<double>>& factors) {
  std::vector<control::CompactControl> controls = controls_of(v);
  control::CompactControl::combine(controls, factors);
  std::vector<CompactJointVector> combined(factors.size());
  for (std::size_t j = 0; j < factors.size(); ++j) {
    combined[j].u = controls[j];
    combined[j].x.assign(v.empty() ? 0 : v.front().x.size(), 0.0);
    for (std::size_t i = 0; i < v.size(); ++i)
      axpy(factors[j][i], v[i].x, combined[j].x);
  }
  v = std::move(combined);
}

/// A point of the search: the scene and its motion there.
struct JointProblem::Point {
  Point(FitProblem& fit, const control::ControlSpace& controls, Vector at, Timers& timers)
      : v(std::move(at)), theta(fit.values(v.x)), scene(scene::with_values(fit.scene(), theta)),
        problem(fit.discretisation(), scene, fit.needs(), timers), force(controls, v.u),
        measurements(problem.stepper, problem.grid, scene, fit.times()),
        rates(problem.stepper, fit.scene(), theta),
        storage(problem.stepper, problem.grid, scene.trajectory, 1, timers),
        motion(problem.stepper, problem.initial, storage, true) {}

  Vector v;
  std::vector<double> theta;
  scene::Scene scene;
  Problem problem;
  control::ControlForce force; ///< of v.u
  control::Measurements measurements;
  forward::ParameterRates rates;
  forward::StateStoreFactory storage;
  forward::Trajectory motion;
  std::vector<double> squared_distances, residuals;
  Value value;
};

JointProblem::JointProblem(FitProblem& fit, const ControlProblem& control, const Vector& guess,
                           Timers& timers)
    : fit_(fit), control_(control), timers_(timers), weights_(guess.x.size(), 1.0) {
  const control::ControlForce force(control.controls, guess.u);
  const std::vector<double> H = fit.evaluate(guess.x, &force).normal_matrix();
  // The curvature of J along its steepest descent by the control alone.
  (void)value(guess);
  Vector down = trial_gradient();
  accept();
  down.scale(-1);
  std::ranges::fill(down.x, 0);
  const double squared = inner(down, down);
  const double curvature = squared > 0 ? inner(down, hessian_product(down)) / squared : 0;
  for (std::size_t j = 0; j < weights_.size(); ++j)
    if (const double told = H[j * weights_.size() + j]; told > 0 && curvature > 0)
      weights_[j] = told / curvature;
}

JointProblem::~JointProblem() = default;

std::unique_ptr<JointProblem::Point> JointProblem::made(const Vector& v) {
  std::unique_ptr<Point> point;
  try {
    point = std::make_unique<Point>(fit_, control_.controls, v, timers_);
  } catch (const UserError& error) {
    throw SolverFailure(error.what());
  }
  Point& at = *point;
  {
    const auto timer = timers_.time("forward");
    at.motion.run(at.problem.load(&at.force), [&](const forward::Frame& frame) {
      control_.objective.observe(frame.step.k, frame.after.y(), at.squared_distances);
      at.measurements.observe(frame);
    });
  }
  if (at.motion.steps() < at.problem.steps())
    throw Interrupted();
  ++sweeps_.forward;
  at.residuals = fit_.residuals(at.measurements.values(), at.v.x);
  at.value = {control_.objective.value(at.squared_distances, at.v.u),
              optimize::LeastSquares{at.residuals, {}}.value()};
  return point;
}

double JointProblem::value(const Vector& v) {
  trial_gradient_.reset();
  for (std::size_t j = 0; current_ && j < v.x.size(); ++j)
    if (!fit_.box().reaches(j, current_->v.x[j], v.x[j]))
      throw SolverFailure(fmt::format("{} would change by a factor of {:.3g} in one step",
                                      fit_.scene().unknowns[j].name,
                                      std::exp(std::abs(v.x[j] - current_->v.x[j]))));
  trial_ = made(v);
  return trial_->value.total();
}

JointProblem::Vector JointProblem::gradient(Point& at, const std::function<void(int k, Vec p)>& visit) {
  const auto timer = timers_.time("adjoint");
  at.measurements.set_derivative(fit_.by_values(at.residuals));
  const control::Derivative derivative(control_.objective, at.motion);
  const forward::DualAtStep duals(at.problem.space, {&derivative, &at.measurements});
  forward::Stepper::Workspace work = at.problem.stepper.workspace();
  Vector g(at.v.u, {});
  g.u.scale(control_.objective.alpha());
  const std::vector<double> by_theta = adjoint::sweep(at.problem.stepper, work, at.motion, duals,
                                                      at.measurements, at.rates, [&](int k, Vec p) {
                                                        control_.controls.add_riesz(k, p, g.u);
                                                        if (visit)
                                                          visit(k, p);
                                                      });
  g.x = fit_.on_scale_gradient(by_theta, at.residuals, at.v.x);
  control_.controls.to_inner(g.u);
  for (std::size_t j = 0; j < g.x.size(); ++j)
    g.x[j] /= weights_[j];
  ++sweeps_.adjoint;
  return g;
}

JointProblem::Vector JointProblem::trial_gradient() {
  trial_gradient_ = gradient(*trial_, {});
  return *trial_gradient_;
}

void JointProblem::accept() {
  current_ = std::move(trial_);
  gradient_ = std::exchange(trial_gradient_, std::nullopt);
}

const JointProblem::Vector& JointProblem::current_gradient() {
  if (!gradient_)
    gradient_ = gradient(*current_, {});
  return *gradient_;
}

std::vector<double> JointProblem::gradient_by_unknowns() {
  std::vector<double> by_x = current_gradient().x;
  for (std::size_t j = 0; j < by_x.size(); ++j)
    by_x[j] *= weights_[j];
  return by_x;
}

void JointProblem::adjoint_states(const std::function<void(int k, Vec p)>& visit) {
  (void)gradient(*current_, visit);
}

JointProblem::Vector JointProblem::hessian_product(const Vector& d) {
  const Vector& here = current_gradient();
  const double length = std::sqrt(inner(d, d)), size = std::sqrt(inner(current_->v, current_->v));
  constexpr double part = 1e-5;
  const double epsilon = part * (size > 0 ? size : 1) / length;
  Vector beside = current_->v;
  beside.add(epsilon, d);
  const std::unique_ptr<Point> point = made(beside);
  Vector h = gradient(*point, {});
  h.add(-1, here);
  h.scale(1 / epsilon);
  return h;
}

double JointProblem::inner(const Vector& v, const Vector& w) const {
  double sum = control_.controls.inner(v.u, w.u);
  for (std::size_t j = 0; j < weights_.size(); ++j)
    sum += weights_[j] * v.x[j] * w.x[j];
  return sum;
}

JointProblem::Vector JointProblem::dual(const Vector& v) const {
  Vector functional(control_.controls.dual(v.u), v.x);
  for (std::size_t j = 0; j < weights_.size(); ++j)
    functional.x[j] *= weights_[j];
  return functional;
}

std::vector<double> JointProblem::pairings(std::span<const Vector> duals, std::span<const Compact> w) const {
  std::vector<control::Control> functionals;
  for (const Vector& one : duals)
    functionals.push_back(one.u);
  std::vector<double> products = control_.controls.pairings(functionals, controls_of(w));
  for (std::size_t i = 0; i < duals.size(); ++i)
    for (std::size_t j = 0; j < w.size(); ++j)
      products[i * w.size() + j] +=
          std::inner_product(duals[i].x.begin(), duals[i].x.end(), w[j].x.begin(), 0.0);
  return products;
}

bool JointProblem::bounded() const {
  const auto finite = [](double bound) { return std::isfinite(bound); };
  return control_.controls.bounded() || std::ranges::any_of(fit_.box().lower, finite) ||
         std::ranges::any_of(fit_.box().upper, finite);
}

void JointProblem::project(Vector& v) const {
  control_.controls.project(v.u);
  for (std::size_t j = 0; j < v.x.size(); ++j)
    v.x[j] = std::clamp(v.x[j], fit_.box().lower[j], fit_.box().upper[j]);
}

void JointProblem::zero_blocked(Vector& w, const Vector& v, const Vector& d) const {
  control_.controls.zero_blocked(w.u, v.u, d.u);
  for (std::size_t j = 0; j < w.x.size(); ++j)
    if (fit_.box().blocks(j, v.x[j], -d.x[j]))
      w.x[j] = 0;
}

const JointProblem::Value& JointProblem::value() const { return current_->value; }
const JointProblem::Vector& JointProblem::vector() const { return current_->v; }
const Problem& JointProblem::problem() const { return current_->problem; }
forward::ForceAtStep JointProblem::load() const { return current_->problem.load(&current_->force); }
const forward::Trajectory& JointProblem::trajectory() const { return current_->motion; }
const forward::Trajectory& JointProblem::trial_trajectory() const { return trial_->motion; }
const forward::Load& JointProblem::force() const { return current_->force; }

} // namespace signorini
