#include "contact/condensed_vi.h"
#include <algorithm>

namespace signorini::contact {
using petsc::check;

CondensedVi::CondensedVi(const Constraints& constraints, const Condensation& condensation, const Factorisation& D,
                         const Complementarity& complementarity, Vec layout)
    : constraints_(constraints), condensation_(condensation), D_(D), complementarity_(complementarity),
      length_unit_(constraints.gap_tolerance()), work_(petsc::zero_like(layout)) {
  const PetscInt m = constraints.count();
  double mean = 0;
  for (PetscInt i = 0; i < m; ++i)
    mean += condensation.S()[static_cast<std::size_t>(i * m + i)] / m;
  force_unit_ = length_unit_ / mean;
  check(MatCreateSeqDense(PETSC_COMM_SELF, m, m, nullptr, S_.put()));
  {
    PetscScalar* entries = nullptr;
    check(MatDenseGetArrayWrite(S_, &entries));
    std::ranges::transform(condensation.S(), entries, [&](double s) { return s / mean; });
    check(MatDenseRestoreArrayWrite(S_, &entries));
  }
  check(MatCreateVecs(S_, x_.put(), gap0_.put()));
  petsc::Vector lower = petsc::zero_like(x_), upper = petsc::zero_like(x_);
  check(VecSet(upper, PETSC_INFINITY));
  vi_.emplace("condensed_vi", S_, std::move(lower), std::move(upper), MATSOLVERPETSC);
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

ActiveSet CondensedVi::find_set(std::span<const double> gap0, const ContactState& previous, int& iterations) const {
  {
    const petsc::WriteArray g(gap0_), x(x_);
    for (std::size_t i = 0; i < gap0.size(); ++i) {
      g[i] = gap0[i] / length_unit_;
      x[i] = previous.lambda.empty() ? 0 : std::max(previous.lambda[i], 0.0) / force_unit_;
    }
  }
  // Where the set is right the forces are solved for again, exactly; a hundredth of the gap tolerance tells it.
  constexpr double tolerance = 1e-2;
  iterations += vi_->solve(gap0_, x_, tolerance);
  const petsc::ReadArray x(x_);
  ActiveSet set;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (x[i] > 0)
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
    solve_on(find_set(gap0, previous, state.vi_iterations), gap0, state);
  check(VecCopy(r, work_));
  constraints_.add_normal(-1, state.lambda, work_);
  D_.solve(work_, y);
  constraints_.gap(y, state.gap);
  complementarity_.classify(state);
  return state;
}

} // namespace signorini::contact
