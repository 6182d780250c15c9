#include "forward/simulate.h"
#include "base/error.h"
#include "base/signals.h"
#include "forward/extrapolation.h"
#include <cmath>
#include <fmt/format.h>

namespace signorini::forward {
using petsc::check;

namespace {

/// Sets a field on the clamps to what they do, with which it must agree but for `rounding`, relative to its
/// size.
void hold_clamped(const Stepper& stepper, Vec x, Vec held, double rounding, const char* key) {
  petsc::Vector whole = petsc::copy(x);
  stepper.clamped().clear(x);
  petsc::Vector difference = petsc::copy(whole);
  check(VecAXPBYPCZ(difference, -1, -1, 1, x, held)); // on the clamps alone
  PetscReal size = 0, moved = 0, held_size = 0;
  check(VecNorm(whole, NORM_INFINITY, &size));
  check(VecNorm(held, NORM_INFINITY, &held_size));
  check(VecNorm(difference, NORM_INFINITY, &moved));
  if (moved > rounding * std::max(size, held_size))
    throw UserError(fmt::format(
        "{}: found a difference of {:.4g} to what the clamps do at t = 0, allowed is 0", key, moved));
  check(VecAXPY(x, 1, held));
}

} // namespace

Initial::Initial(const Stepper& stepper, const scene::Initial& scene)
    : y(stepper.space().vector()), v(stepper.space().vector()) {
  petsc::Vector y_held = petsc::zero_like(y), v_held = petsc::zero_like(v);
  if (stepper.motion()) {
    stepper.motion()->position(0, y_held);
    stepper.motion()->initial_velocity(v_held);
  }
  // A velocity taken by differences agrees with one written down to their error only.
  constexpr double rounding = 1e-12, differences = 1e-5;
  const auto given = [&](const std::optional<scene::Components>& field, const char* key, Vec held,
                         double tolerance, Vec x) {
    if (!field) {
      check(VecCopy(held, x));
      return;
    }
    stepper.space().interpolate({*field, key, false}, 0, x);
    hold_clamped(stepper, x, held, tolerance, key);
  };
  given(scene.displacement, "initial.displacement", y_held, rounding, y);
  given(scene.velocity, "initial.velocity", v_held, stepper.motion() ? differences : rounding, v);
  if (stepper.constraints())
    stepper.constraints()->place_outside(y);
}

namespace {

/// Where the state at t_k goes.
struct Place {
  Vec y, v;
  contact::ContactState& contact;
};

/// step ∘ … ∘ step from the initial state through the places that `at(k)` names, of which two are in use at a
/// time; `show(frame)` is told of each.
template <class At, class Show>
void march(const Stepper& stepper, const Initial& initial, const Load& load, int steps, At&& at,
           Show&& show) {
  const LoadAtStep load_at(stepper.space(), load);
  Extrapolation extrapolation(stepper);
  extrapolation.remember(initial.y);
  const Place start = at(0);
  check(VecCopy(initial.y, start.y));
  check(VecCopy(initial.v, start.v));
  if (const contact::Constraints* constraints = stepper.constraints()) // open: no step has made a force yet
    constraints->gap(constraints->psi(), initial.y, start.contact.gap);
  bool last = stop_requested(stepper.space().comm());
  show(Frame{0, nullptr, nullptr, {}, start.y, start.v, start.contact, last});
  for (int k = 1; !last; ++k) {
    const Place before = at(k - 1), after = at(k);
    StepLoad acting;
    try {
      acting = load_at(k);
      extrapolation.guess(after.y);
      stepper.step(k, before.y, before.v, acting, before.contact, after.contact, after.y, after.v);
      extrapolation.remember(after.y);
    } catch (const SolverFailure& failure) {
      throw SolverFailure(
          fmt::format("step {} (t = {:.6g} s): {}", k, stepper.scheme().time(k), failure.what()));
    }
    last = k == steps || stop_requested(stepper.space().comm());
    show(Frame{k, before.y, before.v, acting, after.y, after.v, after.contact, last});
  }
}

} // namespace

int stream(const Stepper& stepper, const Initial& initial, const Load& load, int steps,
           const Watch& watch) {
  Trajectory two(stepper, 1);
  int done = 0;
  march(
      stepper, initial, load, steps,
      [&](int k) {
        const auto i = static_cast<std::size_t>(k % 2);
        return Place{two.y[i], two.v[i], two.contact[i]};
      },
      [&](const Frame& frame) {
        done = frame.k;
        if (watch)
          watch(frame);
      });
  return done;
}

void replay(const Stepper& stepper, const Load& load, const Trajectory& trajectory,
            const Watch& watch) {
  const LoadAtStep load_at(stepper.space(), load);
  watch({0, nullptr, nullptr, {}, trajectory.y[0], trajectory.v[0], trajectory.contact[0],
         trajectory.steps == 0});
  for (int k = 1; k <= trajectory.steps; ++k) {
    const auto i = static_cast<std::size_t>(k);
    watch({k, trajectory.y[i - 1], trajectory.v[i - 1], load_at(k), trajectory.y[i], trajectory.v[i],
           trajectory.contact[i], k == trajectory.steps});
  }
}

void simulate(const Stepper& stepper, const Initial& initial, const Load& load, Trajectory& trajectory,
              const std::function<void(int k)>& after_step) {
  march(
      stepper, initial, load, trajectory.capacity(),
      [&](int k) {
        const auto i = static_cast<std::size_t>(k);
        return Place{trajectory.y[i], trajectory.v[i], trajectory.contact[i]};
      },
      [&](const Frame& frame) {
        trajectory.steps = frame.k;
        if (after_step && frame.k > 0)
          after_step(frame.k);
      });
}

} // namespace signorini::forward
