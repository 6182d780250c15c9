// SPDX-License-Identifier: GPL-3.0-or-later
#include "control/reduced_problem.h"
#include "base/error.h"
#include "base/signals.h"
#include "base/timers.h"
#include "trajectory/parameter_sensitivities.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <optional>
#include <utility>

namespace signorini::control {
using petsc::check;

namespace {
long& problems = count("reduced problems");

/// Linearised displacements δy_0…δy_N, read from a store of states.
class LinearisedMotion final : public step::Displacements {
public:
  explicit LinearisedMotion(trajectory::StateStore& states) : states_(states) {}
  [[nodiscard]] Vec y(const step::TimeStep& step) const override { return states_.at(step.k).y(); }

private:
  trajectory::StateStore& states_;
};

} // namespace

ReducedProblem::ReducedProblem(const Model& model, const ControlSpace& controls, const Objective& objective,
                               Timers& timers)
    : controls_(&controls), objective_(&objective), timers_(timers), work_(model.stepper->workspace()),
      current_(std::make_unique<Evaluation>(controls.zero(), controls_, model, false)),
      trial_(std::make_unique<Evaluation>(current_->v, controls_, model, false)) { // the control is shared
  ++problems;
}

ReducedProblem::ReducedProblem(ModelAt models, const Misfit& misfit, const ControlSpace* controls,
                               const Objective* objective, Timers& timers)
    : models_(std::move(models)), misfit_(&misfit), controls_(controls), objective_(objective),
      timers_(timers), weights_(misfit.box().lower.size(), 1.0) {
  ++problems;
}

std::unique_ptr<ReducedProblem::Evaluation> ReducedProblem::evaluation(const Variables& v) const {
  try {
    return std::make_unique<Evaluation>(v, controls_, models_(v.x, 1, trajectory::Stops::obeyed), true);
  } catch (const UserError& error) {
    throw SolverFailure(error.what());
  }
}

step::ForceAtStep ReducedProblem::load(const Model& model, const ControlForce* force) {
  return {model.stepper->space(), {model.load, force ? force : model.given}};
}

void ReducedProblem::run(Evaluation& at) {
  const auto timer = timers_.time("forward");
  at.trajectory.run(load(at), [&](const trajectory::Frame& frame) {
    if (objective_) {
      const auto other = timers_.time("objective");
      objective_->observe(frame.step.k, frame.after.y(), at.squared_distances);
    }
    if (at.model.measurements)
      at.model.measurements->observe(frame);
  });
  if (at.trajectory.steps() < at.trajectory.grid().steps())
    throw Interrupted();
  ++sweeps_.forward;
  if (objective_)
    at.value = objective_->value(at.squared_distances, at.v.u);
  if (misfit_) {
    at.residuals = misfit_->residuals(at.model.measurements->values(), at.v.x);
    at.value.misfit = optimize::LeastSquares{at.residuals, {}}.value();
  }
}

void ReducedProblem::simulate(const Variables& v) {
  if (!models_) {
    trial_->v = v;
    run(*trial_);
    return;
  }
  for (std::size_t j = 0; current_ && j < v.x.size(); ++j)
    if (!misfit_->box().reaches(j, current_->v.x[j], v.x[j]))
      throw SolverFailure(fmt::format("the unknown {} would change by a factor of {:.3g} in one iteration",
                                      misfit_->scene().unknowns[j].name,
                                      std::exp(std::abs(v.x[j] - current_->v.x[j]))));
  trial_ = evaluation(v);
  run(*trial_);
}

void ReducedProblem::accept() { std::swap(current_, trial_); }

Control ReducedProblem::pull_back(const std::vector<contact::ContactLinearisation>& contact,
                                  const step::DualAtStep& dual, double scale, const Control& u) {
  const auto timer = timers_.time("adjoint");
  Control g = pull_back_by_sweep(contact, dual, scale, u, {});
  ++sweeps_.adjoint;
  return g;
}

Control ReducedProblem::pull_back_by_sweep(const std::vector<contact::ContactLinearisation>& contact,
                                           const step::DualAtStep& dual, double scale, const Control& u,
                                           const AdjointObserver& visit) {
  // g_k = α u_k + τ s/2 p_k (method.md, section 4)
  Control g = u;
  g.scale(scale);
  adjoint::sweep(stepper(), *work_, controls_->grid(), contact, dual, [&](int k, Vec p) {
    controls_->add_riesz(k, p, g);
    if (visit)
      visit(k, p);
  });
  return g;
}

Control ReducedProblem::adjoint(const step::DualAtStep& dual) {
  return pull_back(current_->trajectory.contact(), dual, 0, current_->v.u);
}

Variables ReducedProblem::derivative(Evaluation& at) {
  const auto timer = timers_.time("adjoint");
  Variables g = derivative_by_sweep(at, {});
  ++sweeps_.adjoint;
  return g;
}

Variables ReducedProblem::derivative_by_sweep(Evaluation& at, const AdjointObserver& visit) {
  std::optional<ObjectiveDuals> by_states;
  if (objective_)
    by_states.emplace(*objective_, at.trajectory);
  const step::DualAtStep duals(at.model.stepper->space(),
                               {by_states ? &*by_states : nullptr, at.model.measurements});
  if (!misfit_)
    return pull_back_by_sweep(at.trajectory.contact(), duals, objective_->alpha(), at.v.u, visit);
  at.model.measurements->set_derivative(misfit_->by_values(at.residuals));
  step::Stepper::Workspace work = at.model.stepper->workspace();
  Variables g(at.v.u);
  if (objective_)
    g.u.scale(objective_->alpha());
  const std::vector<double> by_theta =
      adjoint::sweep(*at.model.stepper, work, at.trajectory, duals, *at.model.measurements, *at.model.rates,
                     [&](int k, Vec p) {
                       if (controls_)
                         controls_->add_riesz(k, p, g.u);
                       if (visit)
                         visit(k, p);
                     });
  g.x = misfit_->gradient(by_theta, at.residuals, at.v.x);
  return g;
}

Control ReducedProblem::l2_gradient() { return derivative(*current_).u; }

void ReducedProblem::adjoint_states(const AdjointObserver& visit) {
  (void)derivative_by_sweep(*current_, visit);
}

Variables ReducedProblem::gradient(Evaluation& at) {
  if (at.gradient)
    return *at.gradient;
  Variables g = derivative(at);
  if (controls_)
    controls_->to_inner(g.u);
  for (std::size_t j = 0; j < g.x.size(); ++j)
    g.x[j] /= weights_[j];
  if (misfit_)
    at.gradient = g;
  return g;
}

Variables ReducedProblem::gradient() { return gradient(*current_); }

Variables ReducedProblem::trial_gradient() { return gradient(*trial_); }

std::vector<double> ReducedProblem::gradient_by_parameters() {
  std::vector<double> by_x = gradient().x;
  for (std::size_t j = 0; j < by_x.size(); ++j)
    by_x[j] *= weights_[j];
  return by_x;
}

optimize::LeastSquares ReducedProblem::least_squares(const Variables& v, trajectory::Stops stops) {
  const Model model = models_(v.x, 1 + v.x.size(), stops);
  std::optional<ControlForce> force;
  if (controls_)
    force.emplace(*controls_, v.u);
  const step::TimeGrid& grid = model.storage->grid();
  trajectory::ParameterSensitivities sensitivities(*model.stepper, *model.rates);
  {
    const auto timer = timers_.time("forward");
    const int steps = trajectory::integrate(
        *model.stepper, grid, *model.initial, load(model, force ? &*force : nullptr),
        [&](const trajectory::Frame& frame) {
          const auto linearised = timers_.time("linearised");
          sensitivities.observe(frame);
          model.measurements->observe(frame, sensitivities, *model.rates);
        },
        stops);
    if (steps < grid.steps())
      throw Interrupted();
  }
  sweeps_.forward += 1 + static_cast<int>(v.x.size());
  std::vector<std::vector<double>> by_theta;
  for (std::size_t j = 0; j < v.x.size(); ++j)
    by_theta.push_back(model.measurements->values(j + 1));
  return {misfit_->residuals(model.measurements->values(), v.x), misfit_->jacobian(by_theta, v.x)};
}

void ReducedProblem::weigh_parameters(const Variables& guess) {
  const Sweeps before = sweeps_; // the linearised motions do not count for the search
  const std::vector<double> H = least_squares(guess).normal_matrix();
  sweeps_ = before;
  // The curvature of J along its steepest descent by the control alone.
  simulate(guess);
  Variables down = trial_gradient();
  accept();
  down.scale(-1);
  std::ranges::fill(down.x, 0);
  const double squared = inner(down, down);
  const double curvature = squared > 0 ? inner(down, hessian_product(down)) / squared : 0;
  for (std::size_t j = 0; j < weights_.size(); ++j)
    if (const double identified = H[j * weights_.size() + j]; identified > 0 && curvature > 0) {
      weights_[j] = identified / curvature;
      current_->gradient->x[j] /= weights_[j];
    }
}

/// Integration of S'(u) d by linearised steps from rest.
class ReducedProblem::LinearisedRun {
public:
  LinearisedRun(ReducedProblem& problem, const Control& d, Step make)
      : problem_(problem), make_(std::move(make)), rest_(problem.stepper().state()),
        force_(*problem.controls_, d), forces_(problem.stepper().space(), force_),
        integrator_(problem.stepper(), rest_,
                    [this](const step::TimeStep& at, const step::State& from, step::State& to) {
                      make_(at.k, {at.scheme(), from, forces_.at(at), to});
                    }) {}

  [[nodiscard]] trajectory::TimeIntegrator& integrator() { return integrator_; }

  /// Makes all steps once and passes the states 0…N to `visit`. Throws Interrupted.
  void operator()(const std::function<void(const trajectory::Checkpoint& now)>& visit) {
    const auto timer = problem_.timers_.time("linearised");
    integrator_.restart();
    visit(integrator_.now());
    for (int k = 1; k <= problem_.controls_->steps(); ++k) {
      if (stop_requested(problem_.stepper().space().comm()))
        throw Interrupted();
      integrator_.advance(problem_.controls_->grid().step(k));
      visit(integrator_.now());
    }
    ++problem_.sweeps_.forward;
  }

private:
  ReducedProblem& problem_;
  Step make_;
  step::State rest_;
  ControlForce force_;
  step::ForceAtStep forces_;
  trajectory::TimeIntegrator integrator_;
};

ReducedProblem::Step ReducedProblem::on_current_contact() {
  return [this, &contact = current_->trajectory.contact()](int k, const step::LinearisedStep& step) {
    stepper().linearised_step(step, contact[k], *work_);
  };
}

void ReducedProblem::linearised(const Control& d, const std::function<void(int k, Vec dy)>& visit) {
  LinearisedRun run(*this, d, on_current_contact());
  run([&](const trajectory::Checkpoint& now) {
    if (now.k > 0)
      visit(now.k, now.state.y());
  });
}

ReducedProblem::OneSided ReducedProblem::one_sided_slope(const Control& d) {
  const ObjectiveDuals along(*objective_, current_->trajectory);
  const step::DualAtStep derivative(stepper().space(), along);
  const petsc::Vector work = stepper().space().vector();
  OneSided slope{.contact = current_->trajectory.contact()};
  slope.by_motion = {.value = objective_->alpha() * controls_->product(current_->v.u, d),
                     .size = objective_->alpha() * controls_->norm(current_->v.u) * controls_->norm(d)};
  LinearisedRun run(*this, d, [&](int k, const step::LinearisedStep& step) {
    stepper().one_sided_step(step, slope.contact[k], *work_);
  });
  run([&](const trajectory::Checkpoint& now) {
    if (now.k == 0)
      return;
    const step::StateDual dual = derivative.at(controls_->grid().step(now.k));
    if (dual.density) {
      check(MatMult(*stepper().operators().W, dual.density, work));
      slope.by_motion.add(work, now.state.y());
    }
    if (dual.vector)
      slope.by_motion.add(dual.vector, now.state.y());
  });
  slope.by_gradient =
      controls_->product(pull_back(slope.contact, derivative, objective_->alpha(), current_->v.u), d);
  return slope;
}

Control ReducedProblem::l2_hessian_product(const Control& d) {
  // δy of the load s W d on A_k, then its adjoint with w_k W δy_k in place of ∂J/∂y_k (method.md, section 4)
  LinearisedRun run(*this, d, on_current_contact());
  const std::unique_ptr<trajectory::StateStore> dy = current_->model.storage->place(run.integrator());
  run([&](const trajectory::Checkpoint& now) { dy->keep(now); });
  const LinearisedMotion linearised(*dy);
  const ObjectiveDuals second(*objective_, linearised, ObjectiveDuals::Order::second);
  return pull_back(current_->trajectory.contact(), {stepper().space(), second}, objective_->alpha(), d);
}

Variables ReducedProblem::hessian_product(const Variables& d) {
  if (!models_) {
    Control h = ReducedProblem::l2_hessian_product(d.u); // of the motion of this object alone
    controls_->to_inner(h);
    return h;
  }
  // (g(v + ε d) − g(v))/ε, since parameters change the contact problem itself
  const Variables here = gradient();
  const double length = std::sqrt(inner(d, d)), size = std::sqrt(inner(current_->v, current_->v));
  constexpr double part = 1e-5;
  const double epsilon = part * (size > 0 ? size : 1) / length;
  Variables beside = current_->v;
  beside.add(epsilon, d);
  const std::unique_ptr<Evaluation> there = evaluation(beside);
  run(*there);
  Variables h = gradient(*there);
  h.add(-1, here);
  h.scale(1 / epsilon);
  return h;
}

double ReducedProblem::inner(const Variables& v, const Variables& w) const {
  double sum = controls_ ? controls_->inner(v.u, w.u) : 0;
  for (std::size_t j = 0; j < weights_.size(); ++j)
    sum += weights_[j] * v.x[j] * w.x[j];
  return sum;
}

Variables ReducedProblem::dual(const Variables& v) const {
  Variables functional(controls_ ? controls_->dual(v.u) : v.u, v.x);
  for (std::size_t j = 0; j < weights_.size(); ++j)
    functional.x[j] *= weights_[j];
  return functional;
}

std::vector<double> ReducedProblem::pairings(std::span<const Variables> duals,
                                             std::span<const Compact> w) const {
  std::vector<double> products(duals.size() * w.size());
  if (controls_) {
    std::vector<Control> functionals;
    for (const Variables& one : duals)
      functionals.push_back(one.u);
    products = controls_->pairings(functionals, controls_of(w));
  }
  for (std::size_t i = 0; i < duals.size(); ++i)
    for (std::size_t j = 0; j < w.size(); ++j)
      products[i * w.size() + j] +=
          std::inner_product(duals[i].x.begin(), duals[i].x.end(), w[j].x.begin(), 0.0);
  return products;
}

bool ReducedProblem::bounded() const {
  const auto finite = [](double bound) { return std::isfinite(bound); };
  return (controls_ && controls_->bounded()) ||
         (misfit_ && (std::ranges::any_of(misfit_->box().lower, finite) ||
                      std::ranges::any_of(misfit_->box().upper, finite)));
}

void ReducedProblem::project(Variables& v) const {
  if (controls_)
    controls_->project(v.u);
  for (std::size_t j = 0; j < v.x.size(); ++j)
    v.x[j] = std::clamp(v.x[j], misfit_->box().lower[j], misfit_->box().upper[j]);
}

void ReducedProblem::zero_blocked(Variables& w, const Variables& v, const Variables& d) const {
  if (controls_)
    controls_->zero_blocked(w.u, v.u, d.u);
  for (std::size_t j = 0; j < w.x.size(); ++j)
    if (misfit_->box().blocks(j, v.x[j], -d.x[j]))
      w.x[j] = 0;
}

} // namespace signorini::control
