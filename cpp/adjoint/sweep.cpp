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

void sweep(const forward::Stepper& stepper, forward::Stepper::Workspace& work, const forward::TimeGrid& grid,
           const std::vector<contact::ContactLinearisation>& contact, const forward::DualAtStep& derivative,
           const std::function<void(int k, Vec p)>& visit) {
  ++sweeps;
  forward::AdjointState state = stepper.adjoint_state();
  forward::Extrapolation extrapolation(stepper);
  const int steps = static_cast<int>(contact.size()) - 1;
  const auto at = [&](int k) {
    return forward::StepContact{grid.scheme(k), contact[static_cast<std::size_t>(k)]};
  };
  for (int k = steps; k >= 1; --k) {
    try {
      extrapolation.guess(grid.time(k), state.p);
      stepper.adjoint_step(
          {at(k), k < steps ? std::optional(at(k + 1)) : std::nullopt, derivative.at(grid.step(k)), state},
          work);
      extrapolation.remember(grid.time(k), state.p);
    } catch (const SolverFailure& failure) {
      throw SolverFailure(fmt::format("adjoint step {}: {}", k, failure.what()));
    }
    visit(k, state.p);
    state.advance();
  }
}

} // namespace signorini::adjoint
