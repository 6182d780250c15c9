#include "control/reduced_problem.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/signals.h"
#include "forward/extrapolation.h"
#include <algorithm>
#include <utility>

namespace signorini::control {
using petsc::check;

namespace {
long& problems = count("reduced problems");
}

ReducedProblem::ReducedProblem(const forward::Stepper& stepper, const ControlSpace& controls,
                               const Objective& objective, const forward::Initial& initial,
                               forward::Load load, Timers& timers)
    : stepper_(stepper), controls_(controls), objective_(objective), initial_(initial),
      load_(std::move(load)), timers_(timers),
      current_{controls.zero(), forward::Trajectory(stepper, controls.steps()), {}},
      trial_{controls.zero(), forward::Trajectory(stepper, controls.steps()), {}} {
  ++problems;
}

forward::Load ReducedProblem::load() const { return load_ + controls_.load(current_.u); }

double ReducedProblem::value(const Control& u) {
  trial_.u = u;
  {
    const auto timer = timers_.time("forward");
    forward::simulate(stepper_, initial_, load_ + controls_.load(trial_.u), trial_.trajectory);
  }
  if (trial_.trajectory.steps < controls_.steps())
    throw Interrupted();
  ++sweeps_.forward;
  const auto timer = timers_.time("objective");
  trial_.value = objective_.value(trial_.trajectory, trial_.u);
  return trial_.value.total();
}

void ReducedProblem::accept() { std::swap(current_, trial_); }

Control ReducedProblem::riesz(const Point& at, const forward::Load& dual, double scale, const Control& u) {
  const auto timer = timers_.time("adjoint");
  Control g = controls_.unset();
  for (int k = 1; k <= g.count(); ++k)
    check(VecAXPBY(g.at(k), scale, 0, u.at(k)));
  adjoint::sweep(stepper_, at.trajectory, dual, [&](int k, Vec p) { controls_.add_riesz(k, p, g); });
  ++sweeps_.adjoint;
  return g;
}

Control ReducedProblem::adjoint(const forward::Load& dual) { return riesz(current_, dual, 0, current_.u); }

Control ReducedProblem::l2_gradient(const Point& at) {
  return riesz(at, objective_.derivative(at.trajectory), objective_.alpha(), at.u);
}

Control ReducedProblem::l2_gradient() { return l2_gradient(current_); }

petsc::Series ReducedProblem::adjoint_states(const std::vector<int>& steps) const {
  petsc::Series states(steps.size());
  adjoint::sweep(stepper_, current_.trajectory, objective_.derivative(current_.trajectory),
                 [&](int k, Vec p) {
                   if (const auto wanted = std::ranges::find(steps, k); wanted != steps.end())
                     states[static_cast<std::size_t>(wanted - steps.begin())] = petsc::copy(p);
                 });
  return states;
}

Control ReducedProblem::gradient() {
  Control g = l2_gradient(current_);
  controls_.to_metric(g);
  return g;
}

Control ReducedProblem::trial_gradient() {
  Control g = l2_gradient(trial_);
  controls_.to_metric(g);
  return g;
}

petsc::Series ReducedProblem::linearised(const Control& d) {
  const auto timer = timers_.time("linearised");
  const std::size_t n = static_cast<std::size_t>(controls_.steps());
  petsc::Series dy = petsc::zero_series(initial_.y, n);
  petsc::Vector y0 = petsc::zero_like(initial_.y), v0 = petsc::zero_like(initial_.y),
                v1 = petsc::zero_like(initial_.y);
  const forward::Load load = controls_.load(d);
  const forward::LoadAtStep load_at(stepper_.space(), load);
  forward::Extrapolation extrapolation(stepper_);
  for (std::size_t k = 1; k <= n; ++k) {
    if (stop_requested(stepper_.space().comm()))
      throw Interrupted();
    extrapolation.guess(dy[k - 1]);
    stepper_.linearised_step(k == 1 ? Vec(y0) : Vec(dy[k - 2]), v0, load_at(static_cast<int>(k)),
                             current_.trajectory.contact[k], dy[k - 1], v1);
    extrapolation.remember(dy[k - 1]);
    std::swap(v0, v1);
  }
  ++sweeps_.forward;
  return dy;
}

Control ReducedProblem::l2_hessian_product(const Control& d) {
  const petsc::Series dy = linearised(d);
  return riesz(current_, objective_.second_derivative(dy), objective_.alpha(), d);
}

Control ReducedProblem::hessian_product(const Control& d) {
  Control h = l2_hessian_product(d);
  controls_.to_metric(h);
  return h;
}

} // namespace signorini::control
