#include "control/reduced_problem.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/signals.h"
#include <algorithm>
#include <utility>

namespace signorini::control {
using petsc::check;

namespace {
long& problems = count("reduced problems");
}

ReducedProblem::ReducedProblem(const forward::Stepper& stepper, const ControlSpace& controls,
                               const Objective& objective, const forward::Initial& initial,
                               forward::Load load, const forward::Storage& storage, Timers& timers)
    : stepper_(stepper), controls_(controls), objective_(objective), initial_(initial),
      load_(std::move(load)), storage_(storage), timers_(timers), current_(point()), trial_(point()) {
  ++problems;
}

std::unique_ptr<ReducedProblem::Point> ReducedProblem::point() const {
  return std::unique_ptr<Point>(
      new Point{controls_.zero(), {stepper_, initial_, controls_.steps(), storage_}, {}, {}});
}

forward::Load ReducedProblem::load() const { return load_ + controls_.load(current_->u); }

double ReducedProblem::value(const Control& u) {
  trial_->u = u;
  const auto timer = timers_.time("forward");
  trial_->trajectory.run(load_ + controls_.load(trial_->u), [&](const forward::Frame& frame) {
    const auto other = timers_.time("objective");
    objective_.observe(frame.k, frame.y1, trial_->squared_distances);
  });
  if (trial_->trajectory.steps() < controls_.steps())
    throw Interrupted();
  ++sweeps_.forward;
  trial_->value = objective_.value(trial_->squared_distances, trial_->u);
  return trial_->value.total();
}

void ReducedProblem::accept() { std::swap(current_, trial_); }

Control ReducedProblem::riesz(const std::vector<contact::ContactSets>& contact, const forward::Load& dual, double scale, const Control& u) {
  const auto timer = timers_.time("adjoint");
  Control g = controls_.unset();
  for (int k = 1; k <= g.count(); ++k)
    check(VecAXPBY(g.at(k), scale, 0, u.at(k)));
  adjoint::sweep(stepper_, contact, dual, [&](int k, Vec p) { controls_.add_riesz(k, p, g); });
  ++sweeps_.adjoint;
  return g;
}

Control ReducedProblem::adjoint(const forward::Load& dual) { return riesz(current_->trajectory.contact(), dual, 0, current_->u); }

Control ReducedProblem::l2_gradient(const Point& at) {
  return riesz(at.trajectory.contact(), objective_.derivative([&at](int k) { return at.trajectory.y(k); }), objective_.alpha(), at.u);
}

Control ReducedProblem::l2_gradient() { return l2_gradient(*current_); }

void ReducedProblem::adjoint_states(const std::function<void(int k, Vec p)>& visit) const {
  adjoint::sweep(stepper_, current_->trajectory.contact(),
                 objective_.derivative([this](int k) { return current_->trajectory.y(k); }), visit);
}

Control ReducedProblem::gradient() {
  Control g = l2_gradient(*current_);
  controls_.to_metric(g);
  return g;
}

Control ReducedProblem::trial_gradient() {
  Control g = l2_gradient(*trial_);
  controls_.to_metric(g);
  return g;
}

void ReducedProblem::march_linearised(const Control& d, const std::function<void(forward::March& march)>& use) {
  const std::vector<contact::ContactSets>& contact = current_->trajectory.contact();
  march_linearised(d, [&](int k, Vec y0, Vec v0, forward::StepLoad load, Vec y1, Vec v1) {
    stepper_.linearised_step(y0, v0, load, contact[static_cast<std::size_t>(k)], y1, v1);
  }, use);
}

void ReducedProblem::march_linearised(const Control& d, const Step& step, const std::function<void(forward::March& march)>& use) {
  const petsc::Vector rest = stepper_.space().vector();
  const forward::Load load = controls_.load(d);
  const forward::LoadAtStep load_at(stepper_.space(), load);
  forward::March march(stepper_, rest, rest, [&](int k, Vec y0, Vec v0, Vec y1, Vec v1) {
    step(k, y0, v0, load_at(k), y1, v1);
  });
  use(march);
}

void ReducedProblem::through_linearised(forward::March& march,
                                        const std::function<void(const forward::State& state)>& visit) {
  const auto timer = timers_.time("linearised");
  march.restart();
  visit(march.state());
  for (int k = 1; k <= controls_.steps(); ++k) {
    if (stop_requested(stepper_.space().comm()))
      throw Interrupted();
    march.advance();
    visit(march.state());
  }
  ++sweeps_.forward;
}

void ReducedProblem::linearised(const Control& d, const std::function<void(int k, Vec dy)>& visit) {
  march_linearised(d, [&](forward::March& march) {
    through_linearised(march, [&](const forward::State& state) {
      if (state.k > 0)
        visit(state.k, state.y);
    });
  });
}

ReducedProblem::OneSided ReducedProblem::one_sided_slope(const Control& d) {
  const forward::Load derivative = objective_.derivative([this](int k) { return current_->trajectory.y(k); });
  const forward::LoadAtStep derivative_at(stepper_.space(), derivative);
  const petsc::Vector work = stepper_.space().vector();
  OneSided slope{.contact = current_->trajectory.contact()};
  slope.by_motion = objective_.alpha() * controls_.product(current_->u, d);
  slope.size = objective_.alpha() * controls_.norm(current_->u) * controls_.norm(d);
  const auto add = [&slope](Vec dual, Vec y) {
    PetscReal one = 0, other = 0;
    check(VecNorm(dual, NORM_2, &one));
    check(VecNorm(y, NORM_2, &other));
    slope.by_motion += petsc::dot(dual, y);
    slope.size += one * other;
  };
  const Step step = [&](int k, Vec y0, Vec v0, forward::StepLoad load, Vec y1, Vec v1) {
    stepper_.one_sided_step(y0, v0, load, slope.contact[static_cast<std::size_t>(k)], y1, v1);
  };
  march_linearised(d, step, [&](forward::March& march) {
    through_linearised(march, [&](const forward::State& state) {
      if (state.k == 0)
        return;
      const forward::StepLoad dual = derivative_at(state.k);
      if (dual.density) {
        check(MatMult(*stepper_.operators().W, dual.density, work));
        add(work, state.y);
      }
      if (dual.force)
        add(dual.force, state.y);
    });
  });
  slope.by_gradient = controls_.product(riesz(slope.contact, derivative, objective_.alpha(), current_->u), d);
  return slope;
}

Control ReducedProblem::l2_hessian_product(const Control& d) {
  Control h = controls_.unset();
  march_linearised(d, [&](forward::March& march) {
    const std::unique_ptr<forward::States> dy = storage_.place(march);
    through_linearised(march, [&](const forward::State& state) { dy->keep(state); });
    h = riesz(current_->trajectory.contact(), objective_.second_derivative([&](int k) { return dy->at(k).y; }), objective_.alpha(), d);
  });
  return h;
}

Control ReducedProblem::hessian_product(const Control& d) {
  Control h = l2_hessian_product(d);
  controls_.to_metric(h);
  return h;
}

} // namespace signorini::control
