// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/quantities.h"
#include "base/progress.h"
#include "fem/sampler.h"
#include "problem/problem.h"

namespace signorini::accuracy {

/// Points and times at which fields are compared, the same for every rung of a scene.
struct SamplePoints {
  fem::Quadrature body;
  int dim = 2;
  std::vector<double> times; ///< evenly spaced times from 0 to time.end, s
  std::string digest;        ///< digest of times, points and the mesh of the points; set on rank 0 only

  /// Takes the quadrature points of the scene's mesh. If these are too many, takes those of meshes with 2, 4,
  /// … times the element size, until there are few enough or coarsening does not reduce them. Throws
  /// UserError. Collective.
  SamplePoints(MPI_Comm comm, const scene::Scene& scene);

  /// Multiplies samples of a field (times × points × dim) by the roots of the quadrature weights. The sum of
  /// their squares is then the square of the field's norm in L2(0,T; L2).
  void scale(std::vector<double>& values) const;
};

/// Exact values of quantities, from the scene's table [exact]; fields are evaluated at the samples. Throws
/// UserError.
Exact exact_values(const scene::Scene& scene, const SamplePoints& samples);

/// Simulates the scene of a rung and measures the `wanted` quantities. The control is
/// drivers::evaluation_point() if the scene has an objective, else control.initial. Measuring the gradient
/// takes an adjoint sweep. `estimate`: whether to estimate also the error of J if there is an objective and
/// no material relaxes; the measured seconds and memory do not include this. Throws UserError, SolverFailure,
/// Interrupted. Collective.
Measured measure(MPI_Comm comm, const scene::Scene& scene, const SamplePoints& samples,
                 const std::vector<Quantity>& wanted, bool estimate);

/// Computes all steps of a motion under `load`, and passes each frame to `watch`. If the time steps of the
/// problem are not known, chooses and sets them. Throws SolverFailure, Interrupted. Collective.
void simulate(problem::Problem& problem, const step::ForceAtStep& load,
              const trajectory::StepObserver& watch);

} // namespace signorini::accuracy
