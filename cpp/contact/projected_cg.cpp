#include "contact/projected_cg.h"
#include "base/error.h"
#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <iterator>

namespace signorini::contact {
using petsc::check;

ProjectedCg::ProjectedCg(const Constraints& constraints, const ConjugateGradients& D, Mat matrix,
                         const Complementarity& complementarity)
    : constraints_(constraints), D_(D), matrix_(matrix), complementarity_(complementarity),
      zero_(static_cast<std::size_t>(constraints.count()), 0.0), residual_(petsc::vector_of(matrix)) {
  if (constraints.held())
    diagonal_ = fem::diagonal(matrix);
  set_.reserve(zero_.size());
  next_.reserve(zero_.size());
  wrong_.reserve(zero_.size());
}

void ProjectedCg::evaluate(Vec r, std::span<const double> psi, Vec y, ContactState& state) const {
  constraints_.gap(psi, y, state.gap);
  if (set_.empty()) {
    std::ranges::fill(state.lambda, 0);
  } else {
    check(MatMult(matrix_, y, residual_));
    check(VecAYPX(residual_, -1, r));
    constraints_.forces(set_, residual_, state.lambda); // Nλ = r − D y
  }
  constraints_.next_set(set_, state.lambda, state.gap, next_);
}

void ProjectedCg::solve(Vec r, std::span<const double> psi, const ContactSets& previous, ContactState& state,
                        Vec y) const {
  constexpr int most = 1000, patience = 10;
  const ConjugateGradients::Projector project = [this](Vec x) { constraints_.set_normal(set_, zero_, x); };
  const auto look = [&](Vec x) {
    evaluate(r, psi, x, state);
    return next_ == set_;
  };
  const ConjugateGradients::Judge judge = std::cref(look); // a reference: std::function does not allocate
  set_ = previous.active;
  constraints_.drop_dependent(set_);
  constraints_.hold(diagonal_, r, y); // gaps depend on held components too
  // Block principal pivoting (Júdice and Pires): primal-dual steps as long as the number of candidates on the
  // wrong side reaches a new minimum within `patience` steps, else one node at a time, that of the last
  // candidate on the wrong side, which ends after finitely many steps (Murty).
  std::size_t fewest = zero_.size() + 1;
  int left = patience;
  for (state.vi_iterations = 0;; ++state.vi_iterations) {
    if (state.vi_iterations > most)
      throw SolverFailure(fmt::format("the active set did not settle in {} steps: {} of {} candidates closed",
                                      most, set_.size(), zero_.size()));
    constraints_.set_normal(set_, psi, y);
    if (D_.solve(r, y, project, left > 0 ? judge : nullptr)) {
      evaluate(r, psi, y, state);
      PetscReal size = 0;
      check(VecNorm(y, NORM_INFINITY, &size));
      if (next_ == set_ ||
          complementarity_.holds(state.lambda, state.gap, constraints_.gap_tolerance(), size, D_.tolerance()))
        break;
    }
    wrong_.clear();
    std::ranges::set_symmetric_difference(set_, next_, std::back_inserter(wrong_));
    left = wrong_.size() < fewest ? patience : std::max(left - 1, 0);
    fewest = std::min(fewest, wrong_.size());
    if (left > 0)
      std::swap(set_, next_);
    else
      constraints_.take_node(next_, wrong_.back(), set_);
  }
  if (!previous.active.empty() || state.vi_iterations > 0)
    count_solved();
  complementarity_.classify(state, y, D_.tolerance());
}

void ProjectedCg::solve_sliding(Vec r, const ActiveSet& set, Vec p) const {
  const ConjugateGradients::Projector project = [this, &set](Vec x) {
    constraints_.set_normal(set, zero_, x);
  };
  constraints_.set_normal(set, zero_, p);
  D_.solve(r, p, project, {});
}

} // namespace signorini::contact
