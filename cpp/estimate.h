#pragma once
#include "adjoint/weighted_residual.h"
#include "problem.h"

namespace signorini {

/// The error of J at the current control of a run, J(exact) − J, estimated without a finer run: the adjoint-weighted residual
/// of the motion and, where a control's motion is desired, of that one, and the error of the trapezoidal rule. The control is
/// taken as given. A forward and an adjoint sweep for each motion. Storage "checkpoints" takes half of its budget once more for
/// the desired one. Collective. Throws SolverFailure, Interrupted, WriteFailure.
adjoint::ErrorParts estimate_error(const Problem& problem, const ControlProblem& control_problem);

} // namespace signorini
