// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "io/manifest.h"
#include "optimize/minimize.h"
#include "problem/problem.h"

namespace signorini::drivers {

/// Where a search starts, and what it goes on with if coarser meshes were searched before.
template <template <optimize::TwiceDifferentiable> class Method>
struct SearchStart {
  using Inheritance = optimize::Inheritance<Method<optimize::Dimensionless<control::ReducedProblem>>>;

  control::Variables guess;
  std::optional<Inheritance> inherited{};
};

/// Multiples of the element size and the time step at which search_start() searches first, the coarsest
/// first.
std::vector<int> coarse_multiples(const problem::Problem& problem);

/// From coarse to fine (docs/method.md section 6): where optimizer.start is "coarse" the problem is solved,
/// to about the error of its discretisation, with 4 times and then 2 times the element size and the time
/// step, each search starting from the result of the last, interpolated with all that the method has learned.
/// A level that would be too coarse is left out; one that cannot be meshed or solved is too, and the console
/// says so. Each level searched is appended to `levels`. Else the scene's first guess. The method is one of
/// Lbfgs, NewtonCg, ProjectedGradient. Collective. Throws UserError, Interrupted.
template <template <optimize::TwiceDifferentiable> class Method>
SearchStart<Method> search_start(const problem::Problem& problem, problem::ControlProblem& control_problem,
                                 const optimize::Options& options, const Console& console,
                                 std::vector<io::CoarseLevel>& levels);

} // namespace signorini::drivers
