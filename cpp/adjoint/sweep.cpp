// SPDX-License-Identifier: GPL-3.0-or-later
#include "adjoint/sweep.h"
#include "base/counters.h"
#include "base/error.h"
#include "forward/extrapolation.h"
#include <fmt/format.h>

namespace signorini::adjoint {

namespace {
long& sweeps = count("adjoint sweeps");
}

void sweep(const forward::Stepper& stepper, forward::Stepper::Workspace& work,
           const std::vector<contact::ContactSets>& contact, const forward::DualAtStep& derivative,
           const std::function<void(int k, Vec p)>& visit) {
  ++sweeps;
  petsc::Vector p = stepper.space().vector(), p_next = stepper.space().vector(),
                omega = stepper.space().vector();
  forward::Extrapolation extrapolation(stepper);
  const int steps = static_cast<int>(contact.size()) - 1;
  for (int k = steps; k >= 1; --k) {
    try {
      extrapolation.guess(stepper.grid().time(k), p);
      const auto i = static_cast<std::size_t>(k);
      stepper.adjoint_step(
          {k, contact[i], k < steps ? &contact[i + 1] : nullptr, derivative.at(k), p_next, omega, p}, work);
      extrapolation.remember(stepper.grid().time(k), p);
    } catch (const SolverFailure& failure) {
      throw SolverFailure(fmt::format("adjoint step {}: {}", k, failure.what()));
    }
    visit(k, p);
    std::swap(p, p_next);
  }
}

} // namespace signorini::adjoint
