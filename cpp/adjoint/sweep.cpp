#include "adjoint/sweep.h"
#include "base/error.h"
#include "forward/extrapolation.h"
#include <fmt/format.h>

namespace signorini::adjoint {

void sweep(const forward::Stepper& stepper, const forward::Trajectory& trajectory,
           const std::function<void(int k, Vec ybar)>& add_dual,
           const std::function<void(int k, Vec p)>& visit) {
  petsc::Vector ybar = stepper.space().vector(), vbar = stepper.space().vector(),
                p = stepper.space().vector();
  std::optional<forward::Extrapolation> guess;
  if (stepper.solver().takes_guess())
    guess.emplace(p);
  for (int k = trajectory.steps; k >= 1; --k) {
    try {
      add_dual(k, ybar);
      if (guess)
        guess->guess(p);
      stepper.transposed_step(trajectory.contact[k], ybar, vbar, p);
      if (guess)
        guess->remember(p);
    } catch (const SolverFailure& failure) {
      throw SolverFailure(fmt::format("adjoint step {}: {}", k, failure.what()));
    }
    visit(k, p);
  }
}

} // namespace signorini::adjoint
