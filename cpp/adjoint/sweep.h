#pragma once
#include "forward/step.h"
#include <functional>
#include <vector>

namespace signorini::adjoint {

/// The backward sweep p_N … p_1 (4.40)–(4.41): for each step of a motion the adjoint step on its
/// active set A_k, of `contact` (0…N), sliding on the whole of it. `derivative` is ∂J/∂y_k; `visit(k, p_k)`
/// receives the adjoint states, each valid during the call. Collective. Throws SolverFailure naming the step.
void sweep(const forward::Stepper& stepper, const std::vector<contact::ContactSets>& contact,
           const forward::DualAtStep& derivative, const std::function<void(int k, Vec p)>& visit);

} // namespace signorini::adjoint
