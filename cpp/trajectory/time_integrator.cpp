// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/time_integrator.h"
#include "base/counters.h"
#include "base/error.h"
#include <fmt/format.h>

namespace signorini::trajectory {
using petsc::check;

namespace {
long& vectors = count("trajectory vectors");
constexpr int nowhere = -1;
} // namespace

Checkpoint::Checkpoint(const step::Stepper& stepper) : state(stepper.state()), guesses(stepper) {
  vectors += static_cast<long>(state.parts().size());
}

void Checkpoint::take(const Checkpoint& other) {
  k = other.k;
  state.copy(other.state);
  guesses.take(other.guesses);
}

double Checkpoint::bytes(const step::Stepper& stepper) {
  return (stepper.state_parts() + Extrapolation::vectors(stepper)) * sizeof(PetscScalar) *
         static_cast<double>(stepper.space().dofs());
}

TimeIntegrator::TimeIntegrator(const step::Stepper& stepper, const step::State& start, Step step)
    : start_(start), step_(std::move(step)), now_(stepper), before_(stepper.state()) {
  vectors += static_cast<long>(before_.parts().size());
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

} // namespace signorini::trajectory
