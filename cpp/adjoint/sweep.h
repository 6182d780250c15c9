// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "forward/step.h"
#include <functional>
#include <vector>

namespace signorini::adjoint {

/// The backward sweep p_N … p_1 (4.40)–(4.41), docs/method.md section 4: for each step of a motion the
/// adjoint step on its whole active set A_k, given by `contact` (0…N); `grid` has these N steps.
/// `derivative` is ∂J/∂y_k;
/// `visit(k, p_k)` receives the adjoint states, each valid during the call. Collective. Throws SolverFailure
/// naming the step.
void sweep(const forward::Stepper& stepper, forward::Stepper::Workspace& work, const forward::TimeGrid& grid,
           const std::vector<contact::ContactLinearisation>& contact, const forward::DualAtStep& derivative,
           const std::function<void(int k, Vec p)>& visit);

} // namespace signorini::adjoint
