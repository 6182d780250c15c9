#include "adjoint/sweep.h"
#include "base/counters.h"
#include "base/error.h"
#include "forward/extrapolation.h"
#include <fmt/format.h>

namespace signorini::adjoint {

namespace {
long& sweeps = count("adjoint sweeps");
}

void sweep(const forward::Stepper& stepper, const forward::Trajectory& trajectory,
           const forward::Load& derivative, const std::function<void(int k, Vec p)>& visit) {
  ++sweeps;
  petsc::Vector p = stepper.space().vector(), p_next = stepper.space().vector(), q = stepper.space().vector();
  const forward::LoadAtStep derivative_at(stepper.space(), derivative);
  forward::Extrapolation extrapolation(stepper);
  for (int k = trajectory.steps; k >= 1; --k) {
    try {
      extrapolation.guess(p);
      const auto i = static_cast<std::size_t>(k);
      stepper.adjoint_step(trajectory.contact[i], k < trajectory.steps ? &trajectory.contact[i + 1] : nullptr,
                           derivative_at(k), p_next, q, p);
      extrapolation.remember(p);
    } catch (const SolverFailure& failure) {
      throw SolverFailure(fmt::format("adjoint step {}: {}", k, failure.what()));
    }
    visit(k, p);
    std::swap(p, p_next);
  }
}

} // namespace signorini::adjoint
