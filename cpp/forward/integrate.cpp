#include "forward/integrate.h"
#include "base/error.h"
#include "base/signals.h"
#include "contact/placement.h"
#include <array>
#include <cmath>
#include <fmt/format.h>

namespace signorini::forward {
using petsc::check;

namespace {

/// Sets the clamped entries of a field to their prescribed values `held`. They must agree up to `rounding`,
/// relative to the largest of `scale` and the sizes of both; throws UserError naming `key` if not. Returns
/// the field as it was.
petsc::Vector hold_clamped(const Stepper& stepper, Vec x, Vec held, double rounding, double scale,
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
        "{}: found a difference of {:.4g} to what the clamps do at t = 0, allowed is 0", key, moved));
  check(VecAXPY(x, 1, held));
  return whole;
}

} // namespace

Initial::Initial(const Stepper& stepper, const scene::Initial& scene)
    : y(stepper.space().vector()), v(stepper.space().vector()) {
  petsc::Vector y_held = petsc::zero_like(y), v_held = petsc::zero_like(v);
  // Clamps' velocity after one step: the scale of the error of differences even if they start at rest.
  PetscReal later = 0;
  if (stepper.motion()) {
    PrescribedMotion::At at = stepper.motion()->storage();
    stepper.motion()->evaluate(0, at);
    check(VecCopy(at.position, y_held));
    check(VecCopy(at.velocity, v_held));
    stepper.motion()->evaluate(1, at);
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
  given(scene.displacement, "initial.displacement", y_held, rounding, 0, y);
  const petsc::Vector written =
      given(scene.velocity, "initial.velocity", v_held, stepper.motion() ? differences : rounding, later, v);
  if (stepper.motion())
    stepper.motion()->copy(written, v);
  if (stepper.pairs())
    contact::place_outside(*stepper.pairs(), y);
}

int integrate_with(const Stepper& stepper, TimeIntegrator& integrator, int steps, Stops stops,
                   const std::function<contact::ContactState&(int k)>& contact, const NodalForce& acting,
                   const StepObserver& watch) {
  const auto stopped = [&] { return stops == Stops::obeyed && stop_requested(stepper.space().comm()); };
  integrator.restart();
  if (const contact::ContactPairs* pairs = stepper.pairs()) // no step has computed forces yet
    contact::NormalOperator(*pairs).gap(pairs->psi(), integrator.state().y, contact(0).gap);
  bool last = stopped();
  watch({0, nullptr, nullptr, {}, integrator.state().y, integrator.state().v, contact(0), last});
  int k = 0;
  while (!last) {
    integrator.advance();
    last = ++k == steps || stopped();
    watch({k, integrator.y0(), integrator.v0(), acting, integrator.state().y, integrator.state().v,
           contact(k), last});
  }
  return k;
}

int integrate(const Stepper& stepper, const Initial& initial, const ForceAtStep& load, int steps,
              const StepObserver& watch, Stops stops) {
  NodalForce acting;
  Stepper::Workspace work = stepper.workspace();
  std::array<contact::ContactState, 2> two{contact::ContactState(candidates(stepper)),
                                           contact::ContactState(candidates(stepper))};
  const auto contact = [&](int k) -> contact::ContactState& { return two[static_cast<std::size_t>(k % 2)]; };
  TimeIntegrator integrator(stepper, initial.y, initial.v, [&](int k, Vec y0, Vec v0, Vec y1, Vec v1) {
    acting = load.at(k);
    stepper.step({k, {y0, v0}, acting, contact(k - 1)}, {{y1, v1}, contact(k)}, work);
  });
  return integrate_with(
      stepper, integrator, steps, stops, contact, acting, watch ? watch : [](const Frame&) {});
}

} // namespace signorini::forward
