#pragma once
#include "forward/step.h"
#include "forward/trajectory.h"
#include <functional>

namespace signorini::adjoint {

/// The backward sweep p_N … p_1 (4.40)–(4.41): for each step of `trajectory` the transposed step on its stored active set
/// A_k, sliding on the whole of it. `add_dual(k, ȳ)` adds ∂J/∂y_k; `visit(k, p_k)` receives the adjoint states, each valid
/// during the call. Collective. Throws SolverFailure naming the step.
///
/// The duals that it carries are those of (y_k, v_k); the seed's adjoint velocity is q_{k+1} with
/// R p_{k+1} − τ M q_{k+1} = ȳ_k + (2/τ) v̄_k, before ∂J/∂y_k is added.
void sweep(const forward::Stepper& stepper, const forward::Trajectory& trajectory,
           const std::function<void(int k, Vec ybar)>& add_dual, const std::function<void(int k, Vec p)>& visit);

} // namespace signorini::adjoint
