// SPDX-License-Identifier: GPL-3.0-or-later
#include "forward/time_integrator.h"
#include "base/counters.h"
#include "base/error.h"
#include <fmt/format.h>

namespace signorini::forward {
using petsc::check;

namespace {
long& vectors = count("trajectory vectors");
constexpr int nowhere = -1;
} // namespace

State::State(const Stepper& stepper)
    : y(stepper.space().vector()), v(stepper.space().vector()), guesses(stepper) {
  vectors += 2;
}

void State::take(const State& other) {
  k = other.k;
  check(VecCopy(other.y, y));
  check(VecCopy(other.v, v));
  guesses.take(other.guesses);
}

double State::bytes(const Stepper& stepper) {
  return (2 + Extrapolation::vectors(stepper)) * sizeof(PetscScalar) *
         static_cast<double>(stepper.space().dofs());
}

TimeIntegrator::TimeIntegrator(const Stepper& stepper, Vec y, Vec v, Step step)
    : y_start_(y), v_start_(v), step_(std::move(step)), state_(stepper), y0_(stepper.space().vector()),
      v0_(stepper.space().vector()) {
  vectors += 2;
  state_.k = nowhere;
}

void TimeIntegrator::restart() {
  check(VecCopy(y_start_, state_.y));
  check(VecCopy(v_start_, state_.v));
  state_.guesses.forget();
  state_.k = 0;
}

void TimeIntegrator::resume(const State& state) { state_.take(state); }

void TimeIntegrator::advance(const TimeStep& step) {
  state_.k = nowhere;
  state_.guesses.remember(step.begin, state_.y);
  std::swap(state_.y, y0_);
  std::swap(state_.v, v0_);
  try {
    state_.guesses.guess(step.end, state_.y);
    step_(step, y0_, v0_, state_.y, state_.v);
  } catch (const SolverFailure& failure) {
    throw SolverFailure(fmt::format("step {} (t = {:.6g} s): {}", step.k, step.end, failure.what()));
  }
  state_.k = step.k;
}

void TimeIntegrator::take_back() {
  std::swap(state_.y, y0_);
  std::swap(state_.v, v0_);
  --state_.k;
}

} // namespace signorini::forward
