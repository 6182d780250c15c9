// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "adjoint/weighted_residual.h"
#include "base/error.h"
#include "problem/problem.h"
#include <string>
#include <vector>

namespace signorini::accuracy {

/// Returns a key of the scene whose effect estimate_error() does not include, with the reason, for messages;
/// empty if it includes all effects.
[[nodiscard]] std::string not_estimated(const scene::Scene& scene);
/// Throws UserError unless estimate_error() includes all effects of the scene. `option`: option that needs
/// the estimate; `instead`: remedy, for the message.
void require_estimable(const scene::Scene& scene, const char* option, const char* instead);

/// Estimates the error J(exact) − J at the current control of `control_problem`, without a finer run
/// (docs/method.md section 7). The parts of the estimate are:
///  - the adjoint-weighted residual of the motion, including the interpolation errors of loads, minus that of
///    the desired motion if a reference control determines the desired motion;
///  - the error of the quadrature in time;
///  - the interpolation error of initial data, weighted with the adjoint;
///  - the interpolation error δ of a given desired displacement y_d, by its effect on J,
///    Σ_k ½ weight(k) (‖e_k − δ_k‖² − ‖e_k‖²) with e_k = y_k − y_d,k.
/// In space, residuals and interpolation errors are evaluated in functions of degree 2; for elements of
/// degree 2 only the errors in time are estimated. The control counts as exact. Makes one forward and one
/// adjoint sweep for each motion. With trajectory.storage = "checkpoints" and a reference control, additional
/// checkpoints take half of the budget once more. `by_cells`: null, or receives for each owned cell the sum
/// of the moduli of its shares in the space part. No material may relax. Throws SolverFailure, Interrupted,
/// WriteFailure. Collective.
adjoint::ErrorParts estimate_error(const problem::Problem& problem,
                                   const problem::ControlProblem& control_problem,
                                   std::vector<double>* by_cells = nullptr);

/// J at some control on one mesh, and its estimated error.
struct EstimatedValue {
  double J;
  adjoint::ErrorParts error;
};

/// Evaluates J and its error on the mesh and steps of `there`, at a control of the space `from`, which may
/// have another mesh and other steps. `there` keeps this control. Throws UserError, SolverFailure,
/// Interrupted. Collective.
EstimatedValue estimated_value(const control::ControlSpace& from, const control::Control& u,
                               const problem::Problem& problem, problem::ControlProblem& there);

/// Possible error of J on the mesh of `fine`, found by comparison with a mesh whose elements are `ratio` > 1
/// times as wide. An estimate with frozen active sets misses what the mesh changes in them. If errors are at
/// least of first order in the size, the error is at most the change of J divided by ratio − 1, and the part
/// that the estimate η misses is at most the change of J + η divided by ratio − 1. Returns the smaller of the
/// two bounds that follow, since estimates on coarse meshes can be far too large.
double error_by_coarser_mesh(const EstimatedValue& fine, const EstimatedValue& coarse, double ratio);

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
