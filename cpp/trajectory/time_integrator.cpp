// SPDX-License-Identifier: GPL-3.0-or-later
#include "trajectory/time_integrator.h"
#include "base/error.h"
#include "base/timers.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::trajectory {
using petsc::check;

Extrapolation::Extrapolation(const step::Stepper& stepper) : wanted_(stepper.solver().takes_guess()) {
  if (wanted_)
    for (petsc::Vector& x : last_)
      x = stepper.space().vector();
}

void Extrapolation::remember(double t, Vec x) {
  if (!wanted_ || (known_ > 0 && times_.front() == t))
    return;
  std::swap(last_[1], last_[2]);
  std::swap(last_[0], last_[1]);
  times_ = {t, times_[0], times_[1]};
  check(VecCopy(x, last_[0]));
  known_ = std::min(known_ + 1, most);
}

void Extrapolation::guess(double t, Vec out) const {
  for (int i = 0; i < known_; ++i) { // Lagrange's polynomials
    double weight = 1;
    for (int j = 0; j < known_; ++j)
      if (j != i)
        weight *= (t - times_[static_cast<std::size_t>(j)]) /
                  (times_[static_cast<std::size_t>(i)] - times_[static_cast<std::size_t>(j)]);
    check(VecAXPBY(out, weight, i == 0 ? 0 : 1, last_[static_cast<std::size_t>(i)]));
  }
}

void Extrapolation::take(const Extrapolation& other) {
  known_ = other.known_;
  times_ = other.times_;
  for (int i = 0; i < known_; ++i)
    check(VecCopy(other.last_[static_cast<std::size_t>(i)], last_[static_cast<std::size_t>(i)]));
}

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
