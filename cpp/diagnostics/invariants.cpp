// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnostics/invariants.h"
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace signorini::diagnostics {
using petsc::check;

namespace {

/// Whether a defect is worse than another one; NaN is the worst.
bool worse(double a, double b) { return a > b || (std::isnan(a) && !std::isnan(b)); }

double worst_of(double a, double b) { return worse(b, a) ? b : a; }

/// `value` relative to `whole`; zero where it is negative.
double part(double value, double whole) { return value <= 0 ? 0 : value / whole; }

} // namespace

Invariants::Invariants(const step::Stepper& stepper, const BodyFigures& body)
    : stepper_(stepper), mass_(body.mass), crossing_(body.crossing) {
  PetscReal largest = 0;
  check(VecNorm(fem::diagonal(stepper.operators().A), NORM_INFINITY, &largest));
  stiffness_ = largest;
}

void Invariants::observe(const trajectory::Frame& frame, const StepBalance& balance) {
  // Rounding of Ay and y·Ay, to which forces and energies are known at best: large where strains are small
  // relative to the displacement, as of a stiff body in flight.
  PetscReal size = 0;
  check(VecNorm(frame.after.y(), NORM_2, &size));
  const double rounding_of_forces = 10 * std::numeric_limits<double>::epsilon() * stiffness_ * size,
               rounding = rounding_of_forces * size;
  energy_ = std::max(energy_, balance.kinetic_energy + balance.elastic_energy);
  forces_ = std::max(forces_, balance.momentum_scale);
  now_ = {};
  now_[0] = part(std::abs(balance.energy_residual) - rounding, energy_);
  now_[1] = part(
      std::hypot(balance.momentum_residual[0], balance.momentum_residual[1], balance.momentum_residual[2]) -
          rounding_of_forces,
      forces_);
  const double length = stepper_.space().mesh().diameter();
  const contact::ContactState& state = frame.contact;
  const double unit = frame.step.k > 0 ? frame.step.scheme().impulse() : 1; // of λ by forces
  for (const double lambda : state.normal_lambda())
    contact_force_ = std::max(contact_force_, std::abs(lambda) / unit);
  const double scale = std::max(contact_force_, std::sqrt(2 * energy_ * mass_) / crossing_);
  for (std::size_t i = 0; i < state.status.size(); ++i) {
    now_[2] = worst_of(now_[2], part(-state.gap[i], length));
    now_[3] = worst_of(now_[3], part(-state.lambda[i] / unit, scale));
    now_[4] = worst_of(now_[4], part(std::abs(state.lambda[i] / unit * state.gap[i]), scale * length));
  }
  for (std::size_t j = 0; j < now_.size(); ++j)
    if (worse(now_[j], defects_[j].worst)) {
      defects_[j].worst = now_[j];
      defects_[j].step = frame.step.k;
    }
}

double Invariants::complementarity() const { return worst_of(worst_of(now_[2], now_[3]), now_[4]); }

std::optional<std::string> Invariants::violation(double tolerance) const {
  std::size_t worst = 0;
  for (std::size_t j = 1; j < now_.size(); ++j)
    if (worse(now_[j], now_[worst]))
      worst = j;
  if (now_[worst] <= tolerance)
    return std::nullopt;
  return fmt::format("{} is {:.2e}, allowed is {:.0e} (run.tolerance)", defects_[worst].name, now_[worst],
                     tolerance);
}

} // namespace signorini::diagnostics
