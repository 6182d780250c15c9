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
    stepper.constraints()->require_outside(y);
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
void march(const Stepper& stepper, const Initial& initial, const AddLoad& add_load, int steps, At&& at,
           Show&& show) {
  petsc::Vector density = petsc::zero_like(initial.y);
  Extrapolation extrapolation(stepper);
  extrapolation.remember(initial.y);
  const Place start = at(0);
  check(VecCopy(initial.y, start.y));
  check(VecCopy(initial.v, start.v));
  if (const contact::Constraints* constraints = stepper.constraints()) // open: no step has made a force yet
    constraints->gap(initial.y, start.contact.gap);
  bool last = stop_requested(stepper.space().comm());
  show(Frame{0, nullptr, nullptr, nullptr, start.y, start.v, start.contact, last});
  for (int k = 1; !last; ++k) {
    const Place before = at(k - 1), after = at(k);
    try {
      check(VecZeroEntries(density));
      add_load(k, density);
      extrapolation.guess(after.y);
      stepper.step(before.y, before.v, density, before.contact, after.contact, after.y, after.v);
      extrapolation.remember(after.y);
    } catch (const SolverFailure& failure) {
      throw SolverFailure(
          fmt::format("step {} (t = {:.6g} s): {}", k, stepper.scheme().time(k), failure.what()));
    }
    last = k == steps || stop_requested(stepper.space().comm());
    show(Frame{k, before.y, before.v, density, after.y, after.v, after.contact, last});
  }
}

} // namespace

int stream(const Stepper& stepper, const Initial& initial, const AddLoad& add_load, int steps,
           const Watch& watch) {
  Trajectory two(stepper, 1);
  int done = 0;
  march(
      stepper, initial, add_load, steps,
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

void replay(const Stepper& stepper, const AddLoad& add_load, const Trajectory& trajectory,
            const Watch& watch) {
  petsc::Vector density = stepper.space().vector();
  watch({0, nullptr, nullptr, nullptr, trajectory.y[0], trajectory.v[0], trajectory.contact[0],
         trajectory.steps == 0});
  for (int k = 1; k <= trajectory.steps; ++k) {
    const auto i = static_cast<std::size_t>(k);
    check(VecZeroEntries(density));
    add_load(k, density);
    watch({k, trajectory.y[i - 1], trajectory.v[i - 1], density, trajectory.y[i], trajectory.v[i],
           trajectory.contact[i], k == trajectory.steps});
  }
}

void simulate(const Stepper& stepper, const Initial& initial, const AddLoad& add_load, Trajectory& trajectory,
              const std::function<void(int k)>& after_step) {
  march(
      stepper, initial, add_load, trajectory.capacity(),
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
