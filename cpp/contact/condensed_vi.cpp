#include "contact/condensed_vi.h"
#include "base/collective.h"
#include "base/error.h"
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace signorini::contact {
using petsc::check;

CondensedVi::CondensedVi(const Constraints& constraints, const DelassusOperator& condensation,
                         const Complementarity& complementarity)
    : constraints_(constraints), condensation_(condensation), complementarity_(complementarity),
      length_unit_(constraints.gap_tolerance()), gap0_(static_cast<std::size_t>(constraints.count())),
      dual_(constraints.dependent() ? gap0_.size() : 0) {
  forces_.reserve(gap0_.size());
  set_.reserve(gap0_.size());
  next_.reserve(gap0_.size());
}

const CondensedVi::Petsc& CondensedVi::petsc() const {
  if (petsc_)
    return *petsc_;
  auto made = std::make_unique<Petsc>();
  const PetscInt m = constraints_.count();
  const std::vector<double> inverse = condensation_.inverse();
  double mean = 0;
  for (PetscInt i = 0; i < m; ++i)
    mean += inverse[static_cast<std::size_t>(i) * (gap0_.size() + 1)] / m;
  check(MatCreateSeqDense(PETSC_COMM_SELF, m, m, nullptr, made->K.put()));
  {
    PetscScalar* entries = nullptr;
    check(MatDenseGetArrayWrite(made->K, &entries));
    std::ranges::transform(inverse, entries, [&](double k) { return k / mean; });
    check(MatDenseRestoreArrayWrite(made->K, &entries));
  }
  check(MatCreateVecs(made->K, made->x.put(), made->gap0.put()));
  made->constant = petsc::zero_like(made->x);
  petsc::Vector lower = petsc::zero_like(made->x), upper = petsc::zero_like(made->x);
  check(VecSet(upper, PETSC_INFINITY));
  made->vi =
      std::make_unique<LinearVi>("condensed_vi", made->K, std::move(lower), std::move(upper), MATSOLVERPETSC);
  petsc_ = std::move(made);
  return *petsc_;
}

void CondensedVi::solve_on_set(ContactState& state) const {
  const std::size_t m = gap0_.size();
  forces_.clear();
  for (int i : set_)
    forces_.push_back(-gap0_[static_cast<std::size_t>(i)]);
  condensation_.solve_active(set_, forces_);
  std::ranges::fill(state.lambda, 0);
  std::ranges::copy(gap0_, state.gap.begin());
  for (std::size_t j = 0; j < set_.size(); ++j) {
    state.lambda[static_cast<std::size_t>(set_[j])] = forces_[j];
    const double* column = &condensation_.S()[static_cast<std::size_t>(set_[j]) * m];
    for (std::size_t i = 0; i < m; ++i)
      state.gap[i] += column[i] * forces_[j];
  }
}

double CondensedVi::deepest() const { return std::max(0.0, -std::ranges::min(gap0_)); }

bool CondensedVi::holds(const ContactState& state, std::span<const double> psi) const {
  double size = 0;
  for (std::size_t i = 0; i < psi.size(); ++i)
    size = std::max({size, std::abs(psi[i] - gap0_[i]), std::abs(psi[i] - state.gap[i])});
  return complementarity_.holds(state.lambda, state.gap, complementarity_.negligible_gap(deepest(), size),
                                size);
}

void CondensedVi::settle(ContactState& state, std::span<const double> psi, double negligible,
                         int most) const {
  const auto settled = [&] {
    return complementarity_.holds_within(negligible, state.lambda, state.gap) && holds(state, psi);
  };
  for (int i = 0; i < most && !settled(); ++i, ++state.vi_iterations) {
    constraints_.next_set(set_, state.lambda, state.gap, next_);
    std::swap(set_, next_);
    solve_on_set(state);
  }
}

void CondensedVi::find_set(ContactState& state) const {
  const Petsc& solver = petsc();
  {
    const petsc::WriteArray g(solver.gap0), x(solver.x);
    for (std::size_t i = 0; i < gap0_.size(); ++i) {
      g[i] = -gap0_[i] / length_unit_;
      x[i] = std::max(state.gap[i], 0.0) / length_unit_;
    }
  }
  check(MatMult(solver.K, solver.gap0, solver.constant));
  set_.clear();
  try {
    state.vi_iterations += solver.vi->solve(solver.constant, solver.x);
  } catch (const SolverFailure&) { // solve() goes on from this set by primal-dual steps
    for (std::size_t i = 0; i < gap0_.size(); ++i)
      if (gap0_[i] < 0)
        set_.push_back(static_cast<int>(i));
    return;
  }
  const petsc::ReadArray x(solver.x), force(solver.vi->residual());
  for (std::size_t i = 0; i < x.size(); ++i)
    if (force[i] > x[i]) // one of them is zero to the solver's tolerance
      set_.push_back(static_cast<int>(i));
}

void CondensedVi::find_independent_set(ContactState& state) const {
  const auto depends = [this](const ActiveSet& set, int i) { return constraints_.depends(set, i); };
  // 1e-8 is two digits above the rounding of S (Complementarity::negligible_gap()); if gaps of its size
  // counted as penetration, the search could cycle.
  const double tolerance = std::min(length_unit_, 1e-8 * deepest());
  if (!dual_.solve(condensation_.S(), gap0_, tolerance, std::cref(depends), set_, state.lambda,
                   state.vi_iterations))
    throw SolverFailure("the obstacles leave no room for the body");
}

void CondensedVi::search(ContactState& state) const {
  // PETSc counts the entries of a dense matrix in PetscInt.
  const bool fits =
      gap0_.size() * gap0_.size() < static_cast<std::size_t>(std::numeric_limits<PetscInt>::max());
  if (constraints_.dependent() || !fits)
    find_independent_set(state);
  else
    find_set(state);
}

void CondensedVi::decided(ContactState& state) const {
  const MPI_Comm comm = constraints_.comm();
  if (ranks(comm) == 1)
    return;
  set_ = broadcast(comm, set_);
  MPI_Bcast(state.lambda.data(), static_cast<int>(state.lambda.size()), MPI_DOUBLE, 0, comm);
  MPI_Bcast(&state.vi_iterations, 1, MPI_INT, 0, comm);
}

void CondensedVi::solve(Vec r, std::span<const double> psi, const ContactSets& previous, ContactState& state,
                        Vec y) const {
  state.vi_iterations = 0;
  condensation_.predict_gap(r, psi, gap0_);
  set_.clear();
  if (std::ranges::any_of(gap0_, [](double g) { return g < 0; })) {
    count_solved();
    set_ = previous.active;
    constraints_.drop_dependent(set_);
    solve_on_set(state);
    // Closing a residual penetration does spurious work, which is large relative to the motion in a short
    // step even where the penetration is negligible relative to the body; so solve to rounding.
    double size = 0;
    for (std::size_t i = 0; i < gap0_.size(); ++i)
      size = std::max({size, std::abs(psi[i]), std::abs(gap0_[i])});
    const double rounding = 10 * std::numeric_limits<double>::epsilon() * size;
    constexpr int soon = 5; // enough for a change of one or two candidates
    settle(state, psi, std::min(rounding, length_unit_), soon);
    if (!holds(state, psi)) {
      on_root<SolverFailure>(constraints_.comm(), [&] { search(state); });
      decided(state);
      solve_on_set(state);
      // The VI solver may misplace candidates whose gap and force are both zero within its tolerance.
      constexpr int most = 50;
      settle(state, psi, length_unit_, most);
      // Both methods can cycle for a body that is nearly rigid within a step; the dual active-set method
      // cannot.
      if (!holds(state, psi)) {
        on_root<SolverFailure>(constraints_.comm(), [&] { find_independent_set(state); });
        decided(state);
        solve_on_set(state);
      }
    }
  } else {
    std::ranges::fill(state.lambda, 0);
  }
  condensation_.finish_closed(set_, psi, state.lambda, state.gap, y);
  complementarity_.classify(state, y);
}

} // namespace signorini::contact
