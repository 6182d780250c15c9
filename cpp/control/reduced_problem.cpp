// SPDX-License-Identifier: GPL-3.0-or-later
#include "control/reduced_problem.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/signals.h"
#include <algorithm>
#include <optional>
#include <utility>

namespace signorini::control {
using petsc::check;

namespace {
long& problems = count("reduced problems");

/// δy_0…δy_N from the storage of states.
class LinearisedMotion final : public forward::Displacements {
public:
  explicit LinearisedMotion(forward::StateStore& states) : states_(states) {}
  [[nodiscard]] Vec y(const forward::TimeStep& step) const override { return states_.at(step.k).y(); }

private:
  forward::StateStore& states_;
};

} // namespace

ReducedProblem::ReducedProblem(const forward::Stepper& stepper, const ControlSpace& controls,
                               const Objective& objective, const forward::State& initial,
                               const forward::Load* load, const forward::StateStoreFactory& storage,
                               Timers& timers)
    : stepper_(stepper), controls_(controls), objective_(objective), initial_(initial), load_(load),
      storage_(storage), timers_(timers), work_(stepper.workspace()), current_(point()), trial_(point()) {
  trial_->u = current_->u; // shared
  ++problems;
}

std::unique_ptr<ReducedProblem::Point> ReducedProblem::point() const {
  return std::make_unique<Point>(controls_, stepper_, initial_, storage_);
}

void ReducedProblem::simulate(const Control& u) {
  trial_->u = u;
  const auto timer = timers_.time("forward");
  trial_->trajectory.run(load(*trial_), [&](const forward::Frame& frame) {
    const auto other = timers_.time("objective");
    objective_.observe(frame.step.k, frame.after.y(), trial_->squared_distances);
  });
  if (trial_->trajectory.steps() < controls_.steps())
    throw Interrupted();
  ++sweeps_.forward;
  trial_->value = objective_.value(trial_->squared_distances, trial_->u);
}

double ReducedProblem::value(const Control& u) {
  simulate(u);
  return trial_->value.total();
}

void ReducedProblem::accept() { std::swap(current_, trial_); }

Control ReducedProblem::pull_back(const std::vector<contact::ContactLinearisation>& contact,
                                  const forward::DualAtStep& dual, double scale, const Control& u) {
  const auto timer = timers_.time("adjoint");
  Control g = u;
  g.scale(scale);
  adjoint::sweep(stepper_, work_, controls_.grid(), contact, dual,
                 [&](int k, Vec p) { controls_.add_riesz(k, p, g); });
  ++sweeps_.adjoint;
  return g;
}

Control ReducedProblem::adjoint(const forward::DualAtStep& dual) {
  return pull_back(current_->trajectory.contact(), dual, 0, current_->u);
}

Control ReducedProblem::l2_gradient(const Point& at) {
  const Derivative derivative(objective_, at.trajectory);
  return pull_back(at.trajectory.contact(), {stepper_.space(), derivative}, objective_.alpha(), at.u);
}

Control ReducedProblem::l2_gradient() { return l2_gradient(*current_); }

void ReducedProblem::adjoint_states(const std::function<void(int k, Vec p)>& visit) {
  const Derivative derivative(objective_, current_->trajectory);
  adjoint::sweep(stepper_, work_, controls_.grid(), current_->trajectory.contact(),
                 {stepper_.space(), derivative}, visit);
}

Control ReducedProblem::gradient() {
  Control g = l2_gradient(*current_);
  controls_.to_inner(g);
  return g;
}

Control ReducedProblem::trial_gradient() {
  Control g = l2_gradient(*trial_);
  controls_.to_inner(g);
  return g;
}

void ReducedProblem::integrate_linearised(
    const Control& d, const std::function<void(forward::TimeIntegrator& integrator)>& use) {
  const std::vector<contact::ContactLinearisation>& contact = current_->trajectory.contact();
  integrate_linearised(
      d,
      [&](int k, const forward::LinearisedStep& step) {
        stepper_.linearised_step(step, contact[static_cast<std::size_t>(k)], work_);
      },
      use);
}

void ReducedProblem::integrate_linearised(
    const Control& d, const Step& step, const std::function<void(forward::TimeIntegrator& integrator)>& use) {
  const forward::State rest = stepper_.state();
  const ControlForce force(controls_, d);
  const forward::ForceAtStep forces(stepper_.space(), force);
  forward::TimeIntegrator integrator(
      stepper_, rest, [&](const forward::TimeStep& at, const forward::State& from, forward::State& to) {
        step(at.k, {at.scheme(), from, forces.at(at), to});
      });
  use(integrator);
}

void ReducedProblem::make_linearised_steps(forward::TimeIntegrator& integrator,
                                           const std::function<void(const forward::Checkpoint& now)>& visit) {
  const auto timer = timers_.time("linearised");
  integrator.restart();
  visit(integrator.now());
  for (int k = 1; k <= controls_.steps(); ++k) {
    if (stop_requested(stepper_.space().comm()))
      throw Interrupted();
    integrator.advance(controls_.grid().step(k));
    visit(integrator.now());
  }
  ++sweeps_.forward;
}

void ReducedProblem::linearised(const Control& d, const std::function<void(int k, Vec dy)>& visit) {
  integrate_linearised(d, [&](forward::TimeIntegrator& integrator) {
    make_linearised_steps(integrator, [&](const forward::Checkpoint& now) {
      if (now.k > 0)
        visit(now.k, now.state.y());
    });
  });
}

ReducedProblem::OneSided ReducedProblem::one_sided_slope(const Control& d) {
  const Derivative along(objective_, current_->trajectory);
  const forward::DualAtStep derivative(stepper_.space(), along);
  const petsc::Vector work = stepper_.space().vector();
  OneSided slope{.contact = current_->trajectory.contact()};
  slope.by_motion = {.value = objective_.alpha() * controls_.product(current_->u, d),
                     .size = objective_.alpha() * controls_.norm(current_->u) * controls_.norm(d)};
  const Step make = [&](int k, const forward::LinearisedStep& step) {
    stepper_.one_sided_step(step, slope.contact[static_cast<std::size_t>(k)], work_);
  };
  integrate_linearised(d, make, [&](forward::TimeIntegrator& integrator) {
    make_linearised_steps(integrator, [&](const forward::Checkpoint& now) {
      if (now.k == 0)
        return;
      const forward::StateDual dual = derivative.at(controls_.grid().step(now.k));
      if (dual.density) {
        check(MatMult(*stepper_.operators().W, dual.density, work));
        slope.by_motion.add(work, now.state.y());
      }
      if (dual.vector)
        slope.by_motion.add(dual.vector, now.state.y());
    });
  });
  slope.by_gradient =
      controls_.product(pull_back(slope.contact, derivative, objective_.alpha(), current_->u), d);
  return slope;
}

Control ReducedProblem::l2_hessian_product(const Control& d) {
  std::optional<Control> h;
  integrate_linearised(d, [&](forward::TimeIntegrator& integrator) {
    const std::unique_ptr<forward::StateStore> dy = storage_.place(integrator);
    make_linearised_steps(integrator, [&](const forward::Checkpoint& now) { dy->keep(now); });
    const LinearisedMotion linearised(*dy);
    const SecondDerivative second(objective_, linearised);
    h = pull_back(current_->trajectory.contact(), {stepper_.space(), second}, objective_.alpha(), d);
  });
  return *std::move(h);
}

Control ReducedProblem::hessian_product(const Control& d) {
  Control h = l2_hessian_product(d);
  controls_.to_inner(h);
  return h;
}

} // namespace signorini::control
