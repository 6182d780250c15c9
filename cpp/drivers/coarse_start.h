// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "io/manifest.h"
#include "optimize/minimize.h"
#include "problem/problem.h"

namespace signorini::drivers {

/// Start of a search: the first guess, and the method's state inherited from a search on a coarser mesh.
template <template <optimize::TwiceDifferentiable> class Method>
struct SearchStart {
  using Inheritance = optimize::Inheritance<Method<optimize::Dimensionless<control::ReducedProblem>>>;

  control::Variables guess;
  std::optional<Inheritance> inherited{};
};

/// Multiples of the scene's element size and time step for the coarse levels of search_start(), in descending
/// order; empty if the search does not start on coarse meshes.
std::vector<int> coarse_multiples(const problem::Problem& problem);

/// Returns the start of a search: the scene's first guess or, if optimizer.start is "coarse", the result of
/// searches on coarse levels (docs/method.md section 6). The levels have 4 and then 2 times the element size
/// and time step; the second search starts from the interpolated result and method state of the first. Each
/// search stops at about the discretisation error of its level. Levels with too few cells or steps are
/// omitted; levels that cannot be meshed or solved are omitted with a line on the console. Appends a record
/// of each level to `levels`. Method: Lbfgs, NewtonCg or ProjectedGradient. Throws UserError, Interrupted.
/// Collective.
template <template <optimize::TwiceDifferentiable> class Method>
SearchStart<Method> search_start(const problem::Problem& problem, problem::ControlProblem& control_problem,
                                 const optimize::Options& options, const Console& console,
                                 std::vector<io::CoarseLevel>& levels);

} // namespace signorini::drivers
