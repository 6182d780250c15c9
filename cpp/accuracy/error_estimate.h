// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "adjoint/weighted_residual.h"
#include "base/error.h"
#include "problem/problem.h"
#include <vector>

namespace signorini::accuracy {

/// Estimates the error of J at the current control of a run, J(exact) − J, without a finer run
/// (docs/method.md section 7): the adjoint-weighted residual of the motion and, where that of a control is
/// desired, of the desired motion; the error of the quadrature in time; and, in functions of degree 2, the
/// interpolation errors of initial data, weighted with the adjoint, of loads, as part of the residual, and of
/// a desired displacement, δ = y_d⁺ − y_d, by its effect on J, Σ_k ½ weight(k) (‖e_k − δ_k‖² − ‖e_k‖²). The
/// control is taken as given. One forward and one adjoint sweep for each motion. Storage "checkpoints" takes
/// half of its budget once more for the desired one. `by_cells`, if given, receives the moduli of the space
/// part's shares, of each cell owned. Collective. Throws SolverFailure, Interrupted, WriteFailure.
adjoint::ErrorParts estimate_error(const problem::Problem& problem,
                                   const problem::ControlProblem& control_problem,
                                   std::vector<double>* by_cells = nullptr);

/// What half the steps, under the same control, change of J, and what the steps of this run may have missed.
struct Verified {
  double change = 0; ///< modulus
  std::vector<Warning> warnings;
};
/// One forward sweep on either grid; steps of varying length are chosen anew. Collective. Throws UserError,
/// SolverFailure, Interrupted.
Verified verify_with_half_steps(const problem::Problem& problem,
                                const problem::ControlProblem& control_problem);

} // namespace signorini::accuracy
