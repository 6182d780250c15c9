#include "forward/simulate.h"
#include "base/error.h"
#include "base/signals.h"
#include "forward/extrapolation.h"
#include <cmath>
#include <fmt/format.h>

namespace signorini::forward {
using petsc::check;

namespace {

/// Zeroes a field on the clamps, where it must vanish but for the rounding of its expressions.
void hold_clamped(const Stepper& stepper, Vec x, const char* key) {
  constexpr double rounding = 1e-12;
  petsc::Vector whole = petsc::copy(x);
  stepper.clamped().clear(x);
  PetscReal size = 0, moved = 0;
  check(VecNorm(whole, NORM_INFINITY, &size));
  check(VecAXPY(whole, -1, x));
  check(VecNorm(whole, NORM_INFINITY, &moved));
  if (moved > rounding * size)
    throw UserError(
        fmt::format("{}: found {:.4g} on a clamp, allowed is 0 there: a clamp holds still", key, moved));
}

} // namespace

Initial::Initial(const Stepper& stepper, const scene::Initial& scene)
    : y(stepper.space().vector()), v(stepper.space().vector()) {
  if (scene.displacement)
    stepper.space().interpolate({*scene.displacement, "initial.displacement", false}, 0, y);
  if (scene.velocity)
    stepper.space().interpolate({*scene.velocity, "initial.velocity", false}, 0, v);
  hold_clamped(stepper, y, "initial.displacement");
  hold_clamped(stepper, v, "initial.velocity");
  if (stepper.constraints())
    stepper.constraints()->place_outside(y);
}

void simulate(const Stepper& stepper, const Initial& initial, const AddLoad& add_load, Trajectory& trajectory,
              const std::function<void(int k)>& after_step) {
  check(VecCopy(initial.y, trajectory.y[0]));
  check(VecCopy(initial.v, trajectory.v[0]));
  if (const contact::Constraints* constraints = stepper.constraints()) // open: no step has made a force yet
    constraints->gap(constraints->psi(), initial.y, trajectory.contact[0].gap);
  trajectory.steps = 0;
  petsc::Vector density = petsc::zero_like(initial.y);
  Extrapolation extrapolation(stepper);
  extrapolation.remember(initial.y);
  for (int k = 1; k <= trajectory.capacity(); ++k) {
    if (stop_requested(stepper.space().comm()))
      return;
    try {
      check(VecZeroEntries(density));
      add_load(k, density);
      extrapolation.guess(trajectory.y[k]);
      stepper.step(stepper.scheme().time(k), trajectory.y[k - 1], trajectory.v[k - 1], density, trajectory.contact[k - 1],
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
