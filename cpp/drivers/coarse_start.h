// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "io/manifest.h"
#include "optimize/minimize.h"
#include "problem/problem.h"

namespace signorini::drivers {

/// First guess of a search, and its inheritance from searches on coarser meshes.
template <template <optimize::TwiceDifferentiable> class Method>
struct SearchStart {
  using Inheritance = optimize::Inheritance<Method<optimize::Dimensionless<control::ReducedProblem>>>;

  control::Variables guess;
  std::optional<Inheritance> inherited{};
};

/// Multiples of the element size and the time step at which search_start() searches first, the coarsest
/// first.
std::vector<int> coarse_multiples(const problem::Problem& problem);

/// Returns the start of a search: the scene's first guess or, where optimizer.start is "coarse", the result
/// of searches from coarse to fine (docs/method.md section 6). These solve the problem to about the error of
/// its discretisation, with 4 times and then 2 times the element size and the time step. Each starts from the
/// result of the last one, interpolated with the state of the method. A level that is too coarse is left out;
/// so is one that cannot be meshed or solved, with a line on the console. Each level searched is appended to
/// `levels`. The method is one of Lbfgs, NewtonCg, ProjectedGradient. Collective. Throws UserError,
/// Interrupted.
template <template <optimize::TwiceDifferentiable> class Method>
SearchStart<Method> search_start(const problem::Problem& problem, problem::ControlProblem& control_problem,
                                 const optimize::Options& options, const Console& console,
                                 std::vector<io::CoarseLevel>& levels);

} // namespace signorini::drivers
