#include "control/reduced_problem.h"
#include "base/counters.h"
#include "base/error.h"
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
                               forward::AddLoad add_load, Timers& timers)
    : stepper_(stepper), controls_(controls), objective_(objective), initial_(initial),
      add_load_(std::move(add_load)), timers_(timers),
      current_{controls.zero(), forward::Trajectory(stepper, controls.steps()), {}},
      trial_{controls.zero(), forward::Trajectory(stepper, controls.steps()), {}} {
  ++problems;
}

forward::AddLoad ReducedProblem::load() const { return controls_.with(add_load_, current_.u); }

double ReducedProblem::value(const Control& u) {
  trial_.u = u;
  {
    const auto timer = timers_.time("forward");
    forward::simulate(stepper_, initial_, controls_.with(add_load_, trial_.u), trial_.trajectory);
  }
  if (trial_.trajectory.steps < controls_.steps())
    throw Interrupted();
  ++sweeps_.forward;
  const auto timer = timers_.time("objective");
  trial_.value = objective_.value(trial_.trajectory, trial_.u);
  return trial_.value.total();
}

void ReducedProblem::accept() { std::swap(current_, trial_); }

Control ReducedProblem::riesz(const std::function<void(int k, Vec density)>& add_density, double scale,
                              const Control& u) {
  const auto timer = timers_.time("adjoint");
  Control g = controls_.unset();
  // The dual of the density s u_k is (τ²/2) W p; τ of the product is divided out, and W by Riesz: (τ s/2) p.
  const double weight = stepper_.scheme().impulse() / stepper_.scheme().tau * controls_.scale();
  adjoint::sweep(stepper_, current_.trajectory, add_density,
                 [&](int k, Vec p) { check(VecAXPBYPCZ(g.at(k), scale, weight, 0, u.at(k), p)); });
  ++sweeps_.adjoint;
  return g;
}

Control ReducedProblem::adjoint(const std::function<void(int k, Vec density)>& add_density) {
  return riesz(add_density, 0, current_.u);
}

Control ReducedProblem::l2_gradient() {
  return riesz([&](int k, Vec density) { add_derivative(k, density); }, objective_.alpha(), current_.u);
}

void ReducedProblem::add_derivative(int k, Vec density) const {
  objective_.add_derivative(k, current_.trajectory.y[static_cast<std::size_t>(k)], density);
}

petsc::Series ReducedProblem::adjoint_states(const std::vector<int>& steps) const {
  petsc::Series states(steps.size());
  adjoint::sweep(
      stepper_, current_.trajectory, [&](int k, Vec density) { add_derivative(k, density); },
      [&](int k, Vec p) {
        if (const auto wanted = std::ranges::find(steps, k); wanted != steps.end())
          states[static_cast<std::size_t>(wanted - steps.begin())] = petsc::copy(p);
      });
  return states;
}

Control ReducedProblem::gradient() {
  Control g = l2_gradient();
  controls_.to_metric(g);
  return g;
}

petsc::Series ReducedProblem::linearised(const Control& d) {
  const auto timer = timers_.time("linearised");
  const std::size_t n = static_cast<std::size_t>(controls_.steps());
  petsc::Series dy = petsc::zero_series(initial_.y, n);
  petsc::Vector y0 = petsc::zero_like(initial_.y), v0 = petsc::zero_like(initial_.y),
                v1 = petsc::zero_like(initial_.y), density = petsc::zero_like(initial_.y);
  forward::Extrapolation extrapolation(stepper_);
  for (std::size_t k = 1; k <= n; ++k) {
    check(VecZeroEntries(density));
    controls_.add_load(d, static_cast<int>(k), density);
    extrapolation.guess(dy[k - 1]);
    stepper_.linearised_step(k == 1 ? Vec(y0) : Vec(dy[k - 2]), v0, density, current_.trajectory.contact[k],
                             dy[k - 1], v1);
    extrapolation.remember(dy[k - 1]);
    std::swap(v0, v1);
  }
  return dy;
}

Control ReducedProblem::hessian_product(const Control& d) {
  const petsc::Series dy = linearised(d);
  return riesz(
      [&](int k, Vec density) {
        objective_.add_second_derivative(k, dy[static_cast<std::size_t>(k) - 1], density);
      },
      objective_.alpha(), d);
}

} // namespace signorini::control
