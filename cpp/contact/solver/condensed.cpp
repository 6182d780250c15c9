// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/solver/condensed.h"
#include "base/collective.h"
#include "base/error.h"
#include "contact/first_order.h"
#include "contact/lcp/primal_dual.h"
#include "linalg/dense.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <stdexcept>

namespace signorini::contact {
using petsc::check;

namespace {

/// Largest predicted penetration, m; 0 if there is none.
double deepest(std::span<const double> gap0) { return std::max(0.0, -std::ranges::min(gap0)); }

} // namespace

CondensedSolver::CondensedSolver(const ConstraintRows& rows, double diameter, Vec diagonal,
                                 std::unique_ptr<const Condensation> condensation, Residual residual,
                                 double tolerance)
    : rows_(rows), delassus_(rows, std::move(condensation)), complementarity_(rows, diameter, diagonal),
      residual_(std::move(residual)), tolerance_(tolerance), length_unit_(gap_tolerance(diameter)) {}

Workspace CondensedSolver::workspace() const {
  Workspace work = delassus_.workspace();
  if (rows_.dependent())
    work.dual = GoldfarbIdnaniWork(work.gap0.size());
  return work;
}

std::unique_ptr<CondensedVi> CondensedSolver::make_vi() const {
  auto made = std::make_unique<CondensedVi>();
  const PetscInt m = rows_.count();
  const std::vector<double> inverse = delassus_.inverse();
  double mean = 0;
  for (PetscInt i = 0; i < m; ++i)
    mean += inverse[static_cast<std::size_t>(i) * (static_cast<std::size_t>(m) + 1)] / m;
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
  made->vi.emplace("condensed_vi", made->K, std::move(lower), std::move(upper), MATSOLVERPETSC);
  return made;
}

void CondensedSolver::solve_on_set(ContactState& state, Workspace& work) const {
  work.b.clear();
  for (int i : work.set)
    work.b.push_back(-work.gap0[i]);
  delassus_.solve_active(work.set, work.b, work);
  std::ranges::fill(state.lambda, 0);
  std::ranges::copy(work.gap0, state.gap.begin());
  for (std::size_t j = 0; j < work.set.size(); ++j) {
    state.lambda[work.set[j]] = work.b[j];
    const std::span<const double> column = delassus_.column(work.set[j]);
    for (std::size_t i = 0; i < column.size(); ++i)
      state.gap[i] += column[i] * work.b[j];
  }
}

bool CondensedSolver::is_complementary(const ContactState& state, std::span<const double> psi,
                                       std::span<const double> gap0) const {
  double size = 0;
  for (std::size_t i = 0; i < psi.size(); ++i)
    size = std::max({size, std::abs(psi[i] - gap0[i]), std::abs(psi[i] - state.gap[i])});
  return complementarity_.holds(state, complementarity_.negligible_gap(deepest(gap0), size), size);
}

void CondensedSolver::settle(ContactState& state, std::span<const double> psi, double negligible, int most,
                             Workspace& work) const {
  const auto settled = [&] {
    return complementarity_.holds_within(negligible, state) && is_complementary(state, psi, work.gap0);
  };
  for (int i = 0; i < most && !settled(); ++i, ++state.vi_iterations) {
    next_set(rows_, work.set, state.lambda, state.gap, work.next);
    std::swap(work.set, work.next);
    solve_on_set(state, work);
  }
}

void CondensedSolver::find_set(ContactState& state, Workspace& work) const {
  if (!work.condensed)
    work.condensed = make_vi();
  CondensedVi& solver = *work.condensed;
  {
    const petsc::WriteArray g(solver.gap0), x(solver.x);
    for (std::size_t i = 0; i < work.gap0.size(); ++i) {
      g[i] = -work.gap0[i] / length_unit_;
      x[i] = std::max(state.gap[i], 0.0) / length_unit_;
    }
  }
  check(MatMult(solver.K, solver.gap0, solver.constant));
  work.set.clear();
  try {
    state.vi_iterations += solver.vi->solve(solver.constant, solver.x);
  } catch (const SolverFailure&) { // solve() continues from this set by primal-dual steps
    for (std::size_t i = 0; i < work.gap0.size(); ++i)
      if (work.gap0[i] < 0)
        work.set.push_back(static_cast<int>(i));
    return;
  }
  const petsc::ReadArray x(solver.x), force(solver.vi->residual());
  for (std::size_t i = 0; i < x.size(); ++i)
    if (force[i] > x[i]) // one of them is zero to the solver's tolerance
      work.set.push_back(static_cast<int>(i));
}

void CondensedSolver::find_independent_set(ContactState& state, Workspace& work) const {
  const auto depending = [this](const ActiveSet& set, int i) { return depends(rows_, set, i); };
  // 1e-8 is two digits above the rounding of S (Complementarity::negligible_gap()); if gaps of its size
  // counted as penetration, the search could cycle.
  const double tolerance = std::min(length_unit_, 1e-8 * deepest(work.gap0));
  if (!goldfarb_idnani([this](int i) { return delassus_.column(i); }, work.gap0, tolerance,
                       std::cref(depending), work.set, state.lambda, state.vi_iterations, work.dual))
    throw SolverFailure("the obstacles leave no room for the body");
}

void CondensedSolver::search(ContactState& state, Workspace& work) const {
  // PETSc counts the entries of a dense matrix in PetscInt.
  const bool fits =
      work.gap0.size() * work.gap0.size() < static_cast<std::size_t>(std::numeric_limits<PetscInt>::max());
  if (rows_.dependent() || !fits)
    find_independent_set(state, work);
  else
    find_set(state, work);
}

void CondensedSolver::broadcast_decision(ContactState& state, Workspace& work) const {
  const MPI_Comm comm = rows_.comm();
  if (ranks(comm) == 1)
    return;
  work.set = broadcast(comm, work.set);
  MPI_Bcast(state.lambda.data(), static_cast<int>(state.lambda.size()), MPI_DOUBLE, 0, comm);
  MPI_Bcast(&state.vi_iterations, 1, MPI_INT, 0, comm);
}

void CondensedSolver::refine(Vec r, std::span<const double> psi, ContactState& state, Vec y,
                             Workspace& work) const {
  if (!work.residual) {
    work.residual = petsc::zero_like(y);
    work.correction = petsc::zero_like(y);
  }
  constexpr int most = 20;
  for (int i = 0; i < most; ++i) {
    // A pass reduces the error by the ratio of the free motions of the residual and of r.
    constexpr int passes = 3;
    for (int pass = 0; pass < passes; ++pass) {
      rows_.prescribe(work.set, psi, y);
      residual_(y, r, work.residual);
      rows_.apply(-1, state.lambda, work.residual);
      delassus_.solve_linearised({.r = work.residual, .set = work.set, .x = work.correction}, work);
      check(VecAXPY(y, 1, work.correction));
      for (int j : work.set)
        state.lambda[j] += work.mu[j];
    }
    rows_.prescribe(work.set, psi, y);
    rows_.gap(psi, y, state.gap);
    next_set(rows_, work.set, state.lambda, state.gap, work.next);
    if (work.next == work.set || complementarity_.holds_within(length_unit_, state))
      return;
    std::swap(work.set, work.next);
    for (int j : work.next) // the previous set
      if (std::ranges::find(work.set, j) == work.set.end())
        state.lambda[j] = 0;
    ++state.vi_iterations;
  }
}

void CondensedSolver::pivot(ContactState& state, std::span<const double> psi, Workspace& work) const {
  for (BlockPivoting pivoting(rows_);; ++state.vi_iterations) {
    next_set(rows_, work.set, state.lambda, state.gap, work.next);
    if (work.next == work.set || is_complementary(state, psi, work.gap0))
      return;
    pivoting.advance(work.set, work.next, work.wrong);
    solve_on_set(state, work);
  }
}

double CondensedSolver::rounding(std::span<const double> psi, std::span<const double> gap0) const {
  double size = 0;
  for (std::size_t i = 0; i < gap0.size(); ++i)
    size = std::max({size, std::abs(psi[i]), std::abs(gap0[i])});
  return 10 * std::numeric_limits<double>::epsilon() * size;
}

void CondensedSolver::solve_by_sets(const ContactProblem& step, Workspace& work) const {
  const std::span<const double> psi = step.psi;
  ContactState& state = step.state;
  work.set = step.previous;
  drop_dependent(rows_, work.set);
  solve_on_set(state, work);
  if (!delassus_.complete()) {
    pivot(state, psi, work);
    return;
  }
  // Closing a residual penetration does spurious work, which is large relative to the motion in a short
  // step even where the penetration is negligible relative to the body; so solve to rounding.
  constexpr int soon = 5; // enough for a change of one or two candidates
  settle(state, psi, std::min(rounding(psi, work.gap0), length_unit_), soon, work);
  if (is_complementary(state, psi, work.gap0))
    return;
  on_root<SolverFailure>(rows_.comm(), [&] { search(state, work); });
  broadcast_decision(state, work);
  solve_on_set(state, work);
  // The VI solver may misplace candidates whose gap and force are both zero within its tolerance.
  constexpr int most = 50;
  settle(state, psi, length_unit_, most, work);
  // Both methods can cycle for a body that is nearly rigid within a step; the dual active-set method cannot.
  if (!is_complementary(state, psi, work.gap0)) {
    on_root<SolverFailure>(rows_.comm(), [&] { find_independent_set(state, work); });
    broadcast_decision(state, work);
    solve_on_set(state, work);
  }
}

double CondensedSolver::solve_by_laws(const ContactProblem& step, Workspace& work) const {
  ContactState& state = step.state;
  const double negligible = std::min(this->negligible(step.psi, work.gap0), length_unit_);
  laws_.solve(step.guess, negligible, state, work);
  constexpr int passes = 3; // of refinement, where the rounding of S leaves gaps
  for (int pass = 0;; ++pass) {
    delassus_.finish(step.psi, state.lambda, state.gap, step.y, work);
    const double residual = laws_.residual(state);
    if (pass == passes || residual <= negligible)
      return std::max(residual, negligible);
    laws_.newton_step(state, work);
  }
}

void CondensedSolver::solve_one_sided(const LinearisedContact& step, ContactLinearisation& contact,
                                      Workspace& work) const {
  const FirstOrderLaws laws(rows_, contact);
  ContactState change(rows_.groups(), rows_.count());
  change.friction = laws.friction();
  if (step.value.empty() || !step.law.empty())
    throw std::logic_error("one-sided steps take gaps and no right-hand sides of laws");
  delassus_.predict_gap(step.r, {step.x, step.set}, step.value, work.gap0, work.half_solve);
  LawSolver(rows_, delassus_, complementarity_.compliances(), laws.laws())
      .solve({}, negligible(step.value, work.gap0), change, work);
  delassus_.finish(step.value, change.lambda, change.gap, step.x, work);
  if (!step.multipliers.empty())
    std::ranges::copy(change.lambda, step.multipliers.begin());
  laws.select(change, complementarity_, contact);
}

double CondensedSolver::negligible(std::span<const double> psi, std::span<const double> gap0) const {
  double motion = 0;
  for (const double gap : gap0)
    motion = std::max(motion, std::abs(gap));
  constexpr double relative = 1e-13; // rounding of S ρ
  return std::max(rounding(psi, gap0), relative * motion);
}

void CondensedSolver::solve(const ContactProblem& step, Workspace& work) const {
  const auto& [r, psi, previous, state, y, guess] = step;
  state.vi_iterations = 0;
  state.several = false;
  delassus_.predict_gap(r, {y, previous}, psi, work.gap0, work.half_solve);
  work.set.clear();
  bool open = true;
  for (int i = 0; i < rows_.groups(); ++i) {
    const std::array<double, 3> gaps = rows_.of_group(i, work.gap0);
    open = open && rows_.law(i).stays_open({gaps.data(), rows_.size(i)});
  }
  if (open)
    std::ranges::fill(state.lambda, 0);
  else
    count_solved();
  double residual = 0;
  if (!open && !rows_.symmetric()) {
    residual = solve_by_laws(step, work);
  } else {
    if (!open)
      solve_by_sets(step, work);
    delassus_.finish_closed(work.set, psi, state.lambda, state.gap, y, work);
    if (residual_ &&
        std::ranges::any_of(work.set, [&](int i) { return std::abs(state.gap[i]) > length_unit_; }))
      refine(r, psi, state, y, work);
  }
  complementarity_.classify(state, y, tolerance_, residual);
}

} // namespace signorini::contact
