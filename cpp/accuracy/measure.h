// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/quantities.h"
#include "base/progress.h"
#include "fem/sampler.h"
#include "problem/problem.h"

namespace signorini::accuracy {

/// Points and times at which fields are compared, the same for every rung of a scene.
struct Samples {
  fem::Quadrature body;
  int dim = 2;
  std::vector<double> times; ///< s, from 0 to time.end at equal distances
  std::string digest;        ///< digest of times, points and the mesh of the points, on rank 0

  /// Quadrature points of the scene's mesh, or of one with twice, four times … its size, until there are few
  /// enough or no fewer. Collective. Throws UserError.
  Samples(MPI_Comm comm, const scene::Scene& scene);

  /// Scales samples (times × points × dim), in place, so that the sum of their squares is the square of the
  /// norm in L2(0,T; L2).
  void scale(std::vector<double>& values) const;
};

/// Exact values of the quantities that have one: the scene's [exact] at the samples. Throws UserError.
Exact exact_values(const scene::Scene& scene, const Samples& samples);

/// Runs the scene of a rung and measures these quantities, with an objective at the control of `check`
/// (drivers::evaluation_point()), else at control.initial; the gradient costs an adjoint sweep. `estimate`:
/// whether to estimate the error of J too, which the seconds do not include. Collective. Throws UserError,
/// SolverFailure, Interrupted.
Measured measure(MPI_Comm comm, const scene::Scene& scene, const Samples& samples,
                 const std::vector<Quantity>& wanted, bool estimate);

/// Makes all steps of a motion and chooses their lengths if they are not known. Collective. Throws
/// SolverFailure, Interrupted.
void simulate(problem::Problem& problem, const step::ForceAtStep& load,
              const trajectory::StepObserver& watch);

} // namespace signorini::accuracy
