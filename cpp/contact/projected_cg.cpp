#include "contact/projected_cg.h"
#include "base/error.h"
#include <fmt/format.h>

namespace signorini::contact {
using petsc::check;

namespace {

petsc::Vector vector_of(Mat matrix) {
  petsc::Vector x;
  check(MatCreateVecs(matrix, x.put(), nullptr));
  return x;
}

} // namespace

ProjectedCg::ProjectedCg(const Constraints& constraints, const ConjugateGradients& D, Mat matrix,
                         const Complementarity& complementarity)
    : constraints_(constraints), D_(D), matrix_(matrix), complementarity_(complementarity),
      zero_(static_cast<std::size_t>(constraints.count()), 0.0), residual_(vector_of(matrix)) {
  set_.reserve(zero_.size());
  next_.reserve(zero_.size());
}

void ProjectedCg::evaluate(Vec r, Vec y, ContactState& state) const {
  check(MatMult(matrix_, y, residual_));
  check(VecAYPX(residual_, -1, r));
  constraints_.gap(y, state.gap);
  constraints_.normal_components(residual_, state.lambda); // D y = r − Nλ
  std::size_t next = 0;
  for (std::size_t i = 0; i < zero_.size(); ++i)
    if (next < set_.size() && set_[next] == static_cast<int>(i))
      ++next;
    else
      state.lambda[i] = 0;
}

void ProjectedCg::solve(Vec r, const ContactState& previous, ContactState& state, Vec y) const {
  const double loose = std::sqrt(D_.tolerance()); // half of the digits tell the set
  constexpr int most = 100;
  const ConjugateGradients::Projector project = [this](Vec x) { constraints_.set_normal(set_, zero_, x); };
  set_ = previous.active;
  state.vi_iterations = 0;
  for (double tolerance = loose;;) {
    constraints_.set_normal(set_, constraints_.psi(), y);
    D_.solve(r, y, project, tolerance);
    evaluate(r, y, state);
    next_.clear();
    for (std::size_t i = 0, in = 0; i < zero_.size(); ++i) {
      const bool closed = in < set_.size() && set_[in] == static_cast<int>(i);
      in += closed;
      if (closed ? state.lambda[i] > 0 : state.gap[i] < 0)
        next_.push_back(static_cast<int>(i));
    }
    const bool settled = next_ == set_;
    if (tolerance == D_.tolerance() && (settled || complementarity_.holds(state.lambda, state.gap)))
      break;
    if (settled) {
      tolerance = D_.tolerance();
      continue;
    }
    if (++state.vi_iterations > most)
      throw SolverFailure(
          fmt::format("the active set did not settle in {} primal-dual steps: {} of {} candidates closed",
                      most, set_.size(), zero_.size()));
    std::swap(set_, next_);
  }
  complementarity_.classify(state);
}

void ProjectedCg::solve_sliding(Vec r, const ActiveSet& set, Vec p) const {
  const ConjugateGradients::Projector project = [this, &set](Vec x) {
    constraints_.set_normal(set, zero_, x);
  };
  constraints_.set_normal(set, zero_, p);
  D_.solve(r, p, project, D_.tolerance());
}

} // namespace signorini::contact
