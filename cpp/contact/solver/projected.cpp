// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/solver/projected.h"
#include "contact/lcp/primal_dual.h"
#include "fem/operators.h"
#include <algorithm>
#include <functional>
#include <stdexcept>

namespace signorini::contact {
using petsc::check;

ProjectedSolver::ProjectedSolver(const ConstraintRows& rows, double diameter, const ConjugateGradients& D,
                                 Mat matrix)
    : rows_(rows), D_(D), matrix_(matrix), complementarity_(rows, diameter, fem::diagonal(matrix)),
      zero_(static_cast<std::size_t>(rows.count()), 0.0), gap_tolerance_(gap_tolerance(diameter)),
      residual_(petsc::vector_of(matrix)) {
  if (!rows.symmetric() || rows.share())
    throw std::logic_error("the projected solver needs symmetric contact laws of nodes alone");
  if (rows_.clamped())
    diagonal_ = fem::diagonal(matrix);
}

void ProjectedSolver::evaluate(Vec r, std::span<const double> psi, Vec y, ContactState& state,
                               Workspace& work) const {
  rows_.gap(psi, y, state.gap);
  if (work.set.empty()) {
    std::ranges::fill(state.lambda, 0);
  } else {
    check(MatMult(matrix_, y, residual_));
    check(VecAYPX(residual_, -1, r));
    rows_.multipliers(work.set, residual_, state.lambda); // Hλ = r − D y
  }
  next_set(rows_, work.set, state.lambda, state.gap, work.next);
}

void ProjectedSolver::solve(const ContactProblem& step, Workspace& work) const {
  const auto& [r, psi, previous, state, y, guess] = step;
  const ConjugateGradients::Projector project = [&](Vec x) { rows_.prescribe(work.set, zero_, x); };
  const auto look = [&](Vec x) {
    evaluate(r, psi, x, state, work);
    return work.next == work.set;
  };
  const ConjugateGradients::TerminationTest judge =
      std::cref(look); // a reference: std::function does not allocate
  work.set = previous;
  drop_dependent(rows_, work.set);
  rows_.set_clamped(diagonal_, r, y); // gaps depend on clamped components too
  for (BlockPivoting pivoting(rows_);; pivoting.advance(work.set, work.next, work.wrong)) {
    state.vi_iterations = pivoting.steps();
    rows_.prescribe(work.set, psi, y);
    if (D_.solve(r, y, project, pivoting.whole() ? judge : nullptr)) {
      evaluate(r, psi, y, state, work);
      PetscReal size = 0;
      check(VecNorm(y, NORM_INFINITY, &size));
      if (work.next == work.set || complementarity_.holds(state, gap_tolerance_, size, D_.tolerance()))
        break;
    }
  }
  if (!previous.empty() || state.vi_iterations > 0)
    count_solved();
  complementarity_.classify(state, y, D_.tolerance());
}

void ProjectedSolver::solve_linearised(const LinearisedContact& step, Workspace&) const {
  const ConjugateGradients::Projector project = [&](Vec x) { rows_.prescribe(step.set, zero_, x); };
  rows_.prescribe(step.set, step.value.empty() ? std::span<const double>(zero_) : step.value, step.x);
  D_.solve(step.r, step.x, project, {});
  if (step.multipliers.empty())
    return;
  check(MatMult(matrix_, step.x, residual_));
  check(VecAYPX(residual_, -1, step.r));
  rows_.multipliers(step.set, residual_, step.multipliers); // Hμ = r − D x
}

void ProjectedSolver::solve_one_sided(const LinearisedContact&, ContactLinearisation&, Workspace&) const {
  throw std::logic_error("symmetric laws need no one-sided solves");
}

} // namespace signorini::contact
