#include "contact/condensed_vi.h"
#include "base/error.h"
#include <algorithm>

namespace signorini::contact {
using petsc::check;

CondensedVi::CondensedVi(const Constraints& constraints, const Condensation& condensation, const Factorisation& D,
                         const Complementarity& complementarity)
    : constraints_(constraints), condensation_(condensation), D_(D), complementarity_(complementarity),
      length_unit_(constraints.gap_tolerance()) {
  const PetscInt m = constraints.count();
  const std::vector<double> inverse = condensation.inverse();
  double mean = 0;
  for (PetscInt i = 0; i < m; ++i)
    mean += inverse[static_cast<std::size_t>(i * m + i)] / m;
  check(MatCreateSeqDense(PETSC_COMM_SELF, m, m, nullptr, K_.put()));
  {
    PetscScalar* entries = nullptr;
    check(MatDenseGetArrayWrite(K_, &entries));
    std::ranges::transform(inverse, entries, [&](double k) { return k / mean; });
    check(MatDenseRestoreArrayWrite(K_, &entries));
  }
  check(MatCreateVecs(K_, x_.put(), gap0_.put()));
  constant_ = petsc::zero_like(x_);
  petsc::Vector lower = petsc::zero_like(x_), upper = petsc::zero_like(x_);
  check(VecSet(upper, PETSC_INFINITY));
  vi_.emplace("condensed_vi", K_, std::move(lower), std::move(upper), MATSOLVERPETSC);
}

void CondensedVi::solve_on(const ActiveSet& set, std::span<const double> gap0, ContactState& state) const {
  const std::size_t m = gap0.size();
  std::vector<double> b;
  for (int i : set)
    b.push_back(-gap0[static_cast<std::size_t>(i)]);
  const std::vector<double> forces = condensation_.solve_active(set, b);
  state.lambda.assign(m, 0);
  state.gap.assign(gap0.begin(), gap0.end());
  for (std::size_t j = 0; j < set.size(); ++j) {
    state.lambda[static_cast<std::size_t>(set[j])] = forces[j];
    const double* column = &condensation_.S()[static_cast<std::size_t>(set[j]) * m];
    for (std::size_t i = 0; i < m; ++i)
      state.gap[i] += column[i] * forces[j];
  }
}

ActiveSet CondensedVi::find_set(std::span<const double> gap0, std::span<const double> guess, int& iterations) const {
  {
    const petsc::WriteArray g(gap0_), x(x_);
    for (std::size_t i = 0; i < gap0.size(); ++i) {
      g[i] = -gap0[i] / length_unit_;
      x[i] = std::max(guess[i], 0.0) / length_unit_;
    }
  }
  check(MatMult(K_, gap0_, constant_));
  ActiveSet set;
  try {
    iterations += vi_->solve(constant_, x_);
  } catch (const SolverFailure&) { // the caller settles the set from here, and fails if that does not end
    for (std::size_t i = 0; i < gap0.size(); ++i)
      if (gap0[i] < 0)
        set.push_back(static_cast<int>(i));
    return set;
  }
  const petsc::ReadArray x(x_), force(vi_->residual());
  for (std::size_t i = 0; i < x.size(); ++i)
    if (force[i] > x[i]) // one of them is zero, to within the solver's tolerance
      set.push_back(static_cast<int>(i));
  return set;
}

ContactState CondensedVi::solve(Vec r, const ContactState& previous, Vec y) const {
  ContactState state;
  std::vector<double> gap0(static_cast<std::size_t>(constraints_.count()));
  D_.solve(r, y);
  constraints_.gap(y, gap0);
  if (std::ranges::all_of(gap0, [](double g) { return g >= 0; })) {
    state.lambda.assign(gap0.size(), 0);
    state.gap = std::move(gap0);
    complementarity_.classify(state);
    return state;
  }
  solve_on(previous.active(), gap0, state);
  if (!complementarity_.holds(state.lambda, state.gap))
    solve_on(find_set(gap0, state.gap, state.vi_iterations), gap0, state);
  // Candidates within the VI solver's tolerance of both bounds may be on the wrong side: primal-dual steps settle them.
  constexpr int most = 50;
  for (int i = 0; i < most && !complementarity_.holds(state.lambda, state.gap); ++i, ++state.vi_iterations) {
    ActiveSet settled;
    for (std::size_t j = 0; j < gap0.size(); ++j)
      if (state.lambda[j] > 0 || (state.lambda[j] == 0 && state.gap[j] < 0))
        settled.push_back(static_cast<int>(j));
    solve_on(settled, gap0, state);
  }
  ActiveSet set;
  for (std::size_t i = 0; i < state.lambda.size(); ++i)
    if (state.lambda[i] != 0)
      set.push_back(static_cast<int>(i));
  condensation_.solve_closed(r, set, state.lambda, y);
  constraints_.gap(y, state.gap);
  complementarity_.classify(state);
  return state;
}

} // namespace signorini::contact
