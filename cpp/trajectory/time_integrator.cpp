// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/time_integrator.h"
#include "base/error.h"
#include "base/signals.h"
#include "base/timers.h"
#include "contact/pairs.h"
#include "contact/placement.h"
#include "trajectory/drop.h"
#include "trajectory/step_control.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

namespace signorini::trajectory {
using petsc::check;

namespace {
long& state_vectors = count("trajectory vectors");
constexpr int nowhere = -1;
} // namespace

Checkpoint::Checkpoint(const step::Stepper& stepper) : state(stepper.state()), guesses(stepper) {
  state_vectors += static_cast<long>(state.parts().size());
}

void Checkpoint::take(const Checkpoint& other) {
  k = other.k;
  state.copy(other.state);
  guesses.take(other.guesses);
}

double Checkpoint::bytes(const step::Stepper& stepper) {
  const std::size_t vectors_stored = stepper.state_parts() + Extrapolation::vectors(stepper);
  return static_cast<double>(vectors_stored * sizeof(PetscScalar)) *
         static_cast<double>(stepper.space().dofs());
}

TimeIntegrator::TimeIntegrator(const step::Stepper& stepper, const step::State& start, Step step)
    : start_(start), step_(std::move(step)), now_(stepper), before_(stepper.state()) {
  state_vectors += static_cast<long>(before_.parts().size());
  now_.k = nowhere;
}

void TimeIntegrator::restart() {
  now_.state.copy(start_);
  now_.guesses.forget();
  now_.k = 0;
}

void TimeIntegrator::resume(const Checkpoint& from) { now_.take(from); }

void TimeIntegrator::advance(const step::TimeStep& step) {
  now_.k = nowhere;
  now_.guesses.remember(step.begin, now_.state.y());
  std::swap(now_.state, before_);
  try {
    now_.guesses.guess(step.end, now_.state.y());
    step_(step, before_, now_.state);
  } catch (const SolverFailure& failure) {
    throw SolverFailure(fmt::format("step {} (t = {:.6g} s): {}", step.k, step.end, failure.what()));
  }
  now_.k = step.k;
}

void TimeIntegrator::take_back() {
  std::swap(now_.state, before_);
  --now_.k;
}

namespace {

/// Sets the clamped entries of the field `x` to their prescribed values `held`, and returns `x` as it was
/// before. Throws UserError naming `key` if entries differ by more than `rounding` times the largest of
/// `scale` and the maximum norms of `x` and `held`.
petsc::Vector hold_clamped(const step::Stepper& stepper, Vec x, Vec held, double rounding, double scale,
                           const char* key) {
  petsc::Vector whole = petsc::copy(x);
  stepper.clamped().clear(x);
  petsc::Vector difference = petsc::copy(whole);
  check(VecAXPBYPCZ(difference, -1, -1, 1, x, held)); // zero on free dofs
  PetscReal size = 0, moved = 0, held_size = 0;
  check(VecNorm(whole, NORM_INFINITY, &size));
  check(VecNorm(held, NORM_INFINITY, &held_size));
  check(VecNorm(difference, NORM_INFINITY, &moved));
  if (moved > rounding * std::max({size, held_size, scale}))
    throw UserError(fmt::format(
        "{}: found values that differ by {:.4g} from those that the clamps prescribe at t = 0; "
        "make them equal{}",
        key, moved,
        stepper.space().mesh().axisymmetric() ? ". On the axis x = 0 the radial value is 0" : ""));
  check(VecAXPY(x, 1, held));
  return whole;
}

} // namespace

step::State initial_state(const step::Stepper& stepper, const scene::Scene& scene) {
  step::State start = stepper.state();
  const Vec y = start.y(), v = start.v();
  petsc::Vector y_held = petsc::zero_like(y), v_held = petsc::zero_like(v);
  // Clamps' velocity after one step: the scale of the error of differences even if they start at rest.
  PetscReal later = 0;
  if (stepper.moving_clamps()) {
    step::MovingClamps::Evaluation at = stepper.moving_clamps()->storage();
    const double tau = stepper.first_length();
    stepper.moving_clamps()->evaluate({.tau = tau}, at);
    check(VecCopy(at.position, y_held));
    check(VecCopy(at.velocity, v_held));
    stepper.moving_clamps()->evaluate({1, 0, tau, tau}, at);
    check(VecNorm(at.velocity, NORM_INFINITY, &later));
  }
  // The clamps' velocity is taken by differences and agrees with the scene's only up to their error, which is
  // `differences` for motions that the steps hardly resolve, of a radian a step. The scene's is right.
  constexpr double rounding = 1e-12, differences = 1e-5;
  const auto given = [&](const std::optional<scene::Components>& field, const char* key, Vec held,
                         double tolerance, double scale, Vec x) {
    if (!field) {
      check(VecCopy(held, x));
      return petsc::copy(held);
    }
    stepper.space().interpolate({*field, key, false}, 0, x);
    return hold_clamped(stepper, x, held, tolerance, scale, key);
  };
  given(scene.initial.displacement, "initial.displacement", y_held, rounding, 0, y);
  const petsc::Vector written = given(scene.initial.velocity, "initial.velocity", v_held,
                                      stepper.moving_clamps() ? differences : rounding, later, v);
  if (stepper.moving_clamps())
    stepper.moving_clamps()->copy(written, v);
  if (scene.initial.drop)
    drop(stepper, scene, y, v);
  if (stepper.velocity_extrapolation())
    stepper.extrapolate(v, stepper.space().vector());
  if (const contact::ContactPairs* pairs = stepper.pairs()) {
    pairs->set_rigid_velocities(v);
    contact::place_outside(*pairs, y);
  }
  return start;
}

namespace {

/// Sets the gaps of the initial state in `contact`, since no step has computed them.
void set_initial_gaps(const step::Stepper& stepper, Vec y, contact::ContactState& contact) {
  if (const contact::ContactPairs* pairs = stepper.pairs())
    pairs->rows().gap(pairs->psi(), y, contact.gap);
}

} // namespace

int integrate_with(const step::Stepper& stepper, const step::TimeGrid& grid, TimeIntegrator& integrator,
                   Stops stops, const std::function<contact::ContactState&(int k)>& contact,
                   const step::NodalForce& acting, const StepObserver& watch,
                   const std::function<bool()>& ended) {
  const auto stopped = [&] { return stops == Stops::obeyed && stop_requested(stepper.space().comm()); };
  integrator.restart();
  set_initial_gaps(stepper, integrator.now().state.y(), contact(0));
  bool last = stopped();
  watch({grid.step(0), nullptr, {}, integrator.now().state, contact(0), last});
  int k = 0;
  while (!last) {
    const step::TimeStep step = grid.step(++k);
    integrator.advance(step);
    last = k == grid.steps() || stopped() || (ended && ended());
    watch({step, &integrator.before(), acting, integrator.now().state, contact(k), last});
  }
  return k;
}

namespace {

/// Integration that stores only the last two states and the contact of the last two steps.
struct Rolling {
  Rolling(const step::Stepper& stepper, const step::State& initial, const step::ForceAtStep& load)
      : work(stepper.workspace()), two{stepper.contact_state(), stepper.contact_state()},
        integrator(stepper, initial,
                   [&](const step::TimeStep& step, const step::State& from, step::State& to) {
                     acting = load.at(step);
                     stepper.step({step, from, acting, contact(step.k - 1)}, {to, contact(step.k)}, work);
                   }) {}

  contact::ContactState& contact(int k) { return two[k % 2]; }

  step::NodalForce acting;
  step::Stepper::Workspace work;
  std::array<contact::ContactState, 2> two;
  TimeIntegrator integrator;
};

} // namespace

int integrate(const step::Stepper& stepper, const step::TimeGrid& grid, const step::State& initial,
              const step::ForceAtStep& load, const StepObserver& watch, Stops stops,
              const std::function<bool()>& ended) {
  Rolling motion(stepper, initial, load);
  return integrate_with(
      stepper, grid, motion.integrator, stops,
      [&](int k) -> contact::ContactState& { return motion.contact(k); }, motion.acting, watch, ended);
}

step::TimeGrid integrate_choosing(const step::Stepper& stepper, const step::State& initial,
                                  const step::ForceAtStep& load, StepControl& control,
                                  const StepObserver& watch) {
  Rolling motion(stepper, initial, load);
  TimeIntegrator& integrator = motion.integrator;
  const auto show = [&](const Frame& frame) {
    if (watch)
      watch(frame);
  };
  integrator.restart();
  const step::State& start = integrator.now().state;
  set_initial_gaps(stepper, start.y(), motion.contact(0));
  control.start(start.y(), start.v(), load);
  bool last = stop_requested(stepper.space().comm());
  show({{.tau = stepper.first_length()}, nullptr, {}, start, motion.contact(0), last});
  while (!last) {
    const step::TimeStep step = control.next_step();
    integrator.advance(step);
    Frame made{step, &integrator.before(), motion.acting, integrator.now().state, motion.contact(step.k),
               false};
    if (!control.accepts(made)) {
      integrator.take_back();
      continue;
    }
    made.last = last = control.steps().complete() || stop_requested(stepper.space().comm());
    show(made);
  }
  return control.steps().grid();
}

} // namespace signorini::trajectory
