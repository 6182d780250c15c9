// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "adjoint/weighted_residual.h"
#include "base/error.h"
#include "problem/problem.h"
#include <vector>

namespace signorini::accuracy {

/// Estimates the error of J at the current control of the reduced problem, J(exact) − J, without a finer run
/// (docs/method.md section 7). The parts of the estimate are:
///  - the adjoint-weighted residual of the motion, and of the desired motion if this is computed from a
///    reference control, with the interpolation errors of loads;
///  - the error of the quadrature in time;
///  - the interpolation error of initial data, weighted with the adjoint;
///  - the interpolation error δ = y_d⁺ − y_d of a desired displacement, by its effect on J,
///    Σ_k ½ weight(k) (‖e_k − δ_k‖² − ‖e_k‖²).
/// Residuals and interpolation errors are those in functions of degree 2. The control counts as exact. Makes
/// one forward and one adjoint sweep for each motion. Storage "checkpoints" uses another half of its budget
/// for the desired motion. `by_cells`: null, or receives for each owned cell the sum of the moduli of its
/// shares in the space part. Throws SolverFailure, Interrupted, WriteFailure. Collective.
adjoint::ErrorParts estimate_error(const problem::Problem& problem,
                                   const problem::ControlProblem& control_problem,
                                   std::vector<double>* by_cells = nullptr);

/// Result of verify_with_half_steps().
struct Verified {
  double change = 0;             ///< modulus of the change of J
  std::vector<Warning> warnings; ///< warnings about the time steps of the given problem
};
/// Computes the change of J with time steps of half the length, under the same control. Makes one forward
/// sweep on each of the two time grids; steps of varying length are chosen anew. Throws UserError,
/// SolverFailure, Interrupted. Collective.
Verified verify_with_half_steps(const problem::Problem& problem,
                                const problem::ControlProblem& control_problem);

} // namespace signorini::accuracy
