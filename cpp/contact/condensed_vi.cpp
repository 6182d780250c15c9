#include "contact/condensed_vi.h"
#include <algorithm>

namespace signorini::contact {
using petsc::check;

namespace {


PetscErrorCode gap_of_forces(SNES snes, Vec lambda, Vec gap, void*) {
  PetscFunctionBeginUser;
  Mat S = nullptr;
  Vec gap0 = nullptr;
  PetscCall(SNESGetJacobian(snes, &S, nullptr, nullptr, nullptr));
  PetscCall(SNESGetApplicationContext(snes, &gap0));
  PetscCall(MatMultAdd(S, lambda, gap0, gap));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode constant_jacobian(SNES, Vec, Mat, Mat, void*) { return PETSC_SUCCESS; }

} // namespace

CondensedVi::CondensedVi(const Constraints& constraints, const Condensation& condensation, const Factorisation& D,
                         const Complementarity& complementarity, Vec layout)
    : constraints_(constraints), condensation_(condensation), D_(D), complementarity_(complementarity),
      work_(petsc::zero_like(layout)) {
  const PetscInt m = constraints.count();
  double mean = 0;
  for (PetscInt i = 0; i < m; ++i)
    mean += condensation.S()[static_cast<std::size_t>(i * m + i)] / m;
  length_unit_ = constraints.gap_tolerance();
  force_unit_ = length_unit_ / mean;
  check(MatCreateSeqDense(PETSC_COMM_SELF, m, m, nullptr, S_.put()));
  {
    PetscScalar* entries = nullptr;
    check(MatDenseGetArrayWrite(S_, &entries));
    std::ranges::transform(condensation.S(), entries, [&](double s) { return s / mean; });
    check(MatDenseRestoreArrayWrite(S_, &entries));
  }
  check(MatSetOption(S_, MAT_SPD, PETSC_TRUE));
  check(MatCreateVecs(S_, x_.put(), residual_.put()));
  for (petsc::Vector* v : {&start_, &gap0_, &lower_, &upper_})
    *v = petsc::zero_like(x_);
  check(VecSet(upper_, PETSC_INFINITY));

  constexpr const char* name = "condensed_vi";
  // Unknowns are in units of the gap tolerance: forces and gaps below a thousandth of it are zero.
  petsc::default_option(name, "snes_vi_zero_tolerance", "1e-3");
  petsc::default_option(name, "snes_atol", "1e-2");
  petsc::default_option(name, "snes_rtol", "0");
  petsc::default_option(name, "snes_stol", "0");
  petsc::default_option(name, "snes_max_it", "100");
  petsc::default_option(name, "snes_linesearch_type", "basic");
  petsc::default_option(name, "ksp_type", "preonly");
  petsc::default_option(name, "pc_type", "lu");
  check(SNESCreate(PETSC_COMM_SELF, snes_.put()));
  check(SNESSetOptionsPrefix(snes_, "condensed_vi_"));
  check(SNESSetType(snes_, SNESVINEWTONRSLS));
  check(SNESSetFunction(snes_, residual_, gap_of_forces, nullptr));
  check(SNESSetJacobian(snes_, S_, S_, constant_jacobian, nullptr));
  check(SNESSetApplicationContext(snes_, static_cast<Vec>(gap0_)));
  check(SNESVISetVariableBounds(snes_, lower_, upper_));
  check(SNESSetFromOptions(snes_));
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
  iterations += solve_vi(snes_, x_, start_, "condensed");
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
