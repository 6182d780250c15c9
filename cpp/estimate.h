#pragma once
#include "adjoint/weighted_residual.h"
#include "problem.h"

namespace signorini {

/// The error of J at the current control of a run, J(exact) − J, estimated without a finer run: the adjoint-weighted residual
/// of the motion and, where a control's motion is desired, of that one, and the error of the trapezoidal rule. The control is
/// taken as given. One forward and one or two adjoint sweeps. Collective. Throws SolverFailure, Interrupted.
adjoint::ErrorParts estimate_error(const Problem& problem, const ControlProblem& control_problem);

} // namespace signorini
