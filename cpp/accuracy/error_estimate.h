// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "adjoint/weighted_residual.h"
#include "base/error.h"
#include "problem/problem.h"
#include <vector>

namespace signorini::accuracy {

/// Estimates the error of J at the current control of a run, J(exact) − J, without a finer run
/// (docs/method.md section 7). Its parts are the adjoint-weighted residual of the motion (and of the desired
/// motion, if that is given by a control) and the error of the quadrature in time. In functions of degree 2
/// there are also interpolation errors: of initial data, weighted with the adjoint, and of loads, within the
/// residual. That of a desired displacement, δ = y_d⁺ − y_d, counts by its effect on J, Σ_k ½ weight(k) (‖e_k
/// − δ_k‖² − ‖e_k‖²). The control is taken as given. Makes one forward and one adjoint sweep for each motion.
/// Storage "checkpoints" takes half of its budget once more for the desired one. `by_cells`, if given,
/// receives the moduli of each owned cell's shares in the space part. Collective. Throws SolverFailure,
/// Interrupted, WriteFailure.
adjoint::ErrorParts estimate_error(const problem::Problem& problem,
                                   const problem::ControlProblem& control_problem,
                                   std::vector<double>* by_cells = nullptr);

/// Change of J with steps of half the length under the same control, and warnings about this run's steps.
struct Verified {
  double change = 0; ///< modulus
  std::vector<Warning> warnings;
};
/// Makes one forward sweep on each of the two grids; steps of varying length are chosen anew. Collective.
/// Throws UserError, SolverFailure, Interrupted.
Verified verify_with_half_steps(const problem::Problem& problem,
                                const problem::ControlProblem& control_problem);

} // namespace signorini::accuracy
