#pragma once
#include "adjoint/weighted_residual.h"
#include "problem.h"

namespace signorini {

/// The error of J at the current control of a run, J(exact) − J, estimated without a finer run: the
/// adjoint-weighted residual of the motion and, where a control's motion is desired, of that one, the error
/// of the trapezoidal rule, and what interpolation takes away: of initial data weighed with the adjoint, of
/// the loads with the residual, of a desired displacement δ = y_d⁺ − y_d, in functions of degree 2, as it
/// enters J, Σ_k ½ weight(k) (‖e_k − δ_k‖² − ‖e_k‖²). The control is taken as given. A forward and an adjoint
/// sweep for each motion. Storage "checkpoints" takes half of its budget once more for the desired one.
/// Collective. Throws SolverFailure, Interrupted, WriteFailure.
adjoint::ErrorParts estimate_error(const Problem& problem, const ControlProblem& control_problem);

} // namespace signorini
