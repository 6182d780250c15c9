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

void simulate(const Stepper& stepper, const Initial& initial, const Load& load, Trajectory& trajectory,
              const std::function<void(int k)>& after_step) {
  check(VecCopy(initial.y, trajectory.y[0]));
  check(VecCopy(initial.v, trajectory.v[0]));
  if (const contact::Constraints* constraints = stepper.constraints()) // open: no step has made a force yet
    constraints->gap(constraints->psi(), initial.y, trajectory.contact[0].gap);
  trajectory.steps = 0;
  const LoadAtStep load_at(stepper.space(), load);
  Extrapolation extrapolation(stepper);
  extrapolation.remember(initial.y);
  for (int k = 1; k <= trajectory.capacity(); ++k) {
    if (stop_requested(stepper.space().comm()))
      return;
    try {
      extrapolation.guess(trajectory.y[k]);
      stepper.step(k, trajectory.y[k - 1], trajectory.v[k - 1], load_at(k), trajectory.contact[k - 1],
                   trajectory.contact[k], trajectory.y[k], trajectory.v[k]);
      extrapolation.remember(trajectory.y[k]);
    } catch (const SolverFailure& failure) {
      throw SolverFailure(
          fmt::format("step {} (t = {:.6g} s): {}", k, stepper.scheme().time(k), failure.what()));
    }
    trajectory.steps = k;
    if (after_step)
      after_step(k);
  }
}

} // namespace signorini::forward
