#pragma once
#include "forward/step.h"
#include "forward/trajectory.h"
#include <functional>

namespace signorini::adjoint {

/// The backward sweep p_N … p_1 (4.40)–(4.41): for each step of `trajectory` the adjoint step on its stored
/// active set A_k, sliding on the whole of it. `derivative` is ∂J/∂y_k, given like a load; `visit(k, p_k)`
/// receives the adjoint states, each valid during the call. Collective. Throws SolverFailure naming the step.
void sweep(const forward::Stepper& stepper, const forward::Trajectory& trajectory,
           const forward::Load& derivative, const std::function<void(int k, Vec p)>& visit);

} // namespace signorini::adjoint
