#include "adjoint/sweep.h"
#include "base/error.h"
#include <fmt/format.h>

namespace signorini::adjoint {

void sweep(const forward::Stepper& stepper, const forward::Trajectory& trajectory,
           const std::function<void(int k, Vec ybar)>& add_dual, const std::function<void(int k, Vec p)>& visit) {
  petsc::Vector ybar = stepper.space().vector(), vbar = stepper.space().vector(), p = stepper.space().vector();
  for (int k = trajectory.steps; k >= 1; --k) {
    try {
      add_dual(k, ybar);
      stepper.transposed_step(trajectory.contact[k], ybar, vbar, p);
    } catch (const SolverFailure& failure) {
      throw SolverFailure(fmt::format("adjoint step {}: {}", k, failure.what()));
    }
    visit(k, p);
  }
}

} // namespace signorini::adjoint
