#include "forward/predictor.h"
#include <algorithm>

namespace signorini::forward {
using petsc::check;

namespace {

petsc::Matrix decoupled(petsc::Matrix M, const fem::DirichletDofs& clamped) {
  clamped.decouple(M);
  return M;
}

} // namespace

Predictor::Predictor(petsc::Matrix blocks, Mat M, const fem::DirichletDofs& clamped,
                     const contact::Constraints& constraints, const scene::Solver& scene, bool sliding)
    : M_(M), clamped_(clamped), constraints_(constraints),
      solver_(decoupled(std::move(blocks), clamped), &constraints, scene, sliding),
      zero_(petsc::vector_of(M)), r_(petsc::zero_like(zero_)), jump_(petsc::zero_like(zero_)),
      before_(constraints.count()), contact_(constraints.count()),
      gap_(static_cast<std::size_t>(constraints.count())) {}

Vec Predictor::jump(std::span<const double> psi, Vec x, const contact::ActiveSet& previous,
                    contact::ActiveSet& set) const {
  set.clear();
  constraints_.gap(psi, x, gap_);
  if (std::ranges::all_of(gap_, [&](double g) { return g >= -constraints_.gap_tolerance(); }))
    return nullptr;
  check(VecZeroEntries(jump_));
  before_.active = previous; // not the set of the last call: a recomputed step must give the same bits
  solver_.vi()->solve(zero_, gap_, before_, contact_, jump_);
  set = contact_.active;
  return jump_;
}

Vec Predictor::linearised_jump(const contact::ActiveSet& set, Vec x) const {
  if (set.empty())
    return nullptr;
  check(MatMult(M_, x, r_));
  clamped_.clear(r_);
  check(VecCopy(x, jump_));
  solver_.sliding()->solve_sliding(r_, set, jump_);
  check(VecAXPY(jump_, -1, x));
  return jump_;
}

double Predictor::bytes() const {
  const StepSolver::Memory memory = solver_.memory();
  return memory.factor + memory.condensation;
}

} // namespace signorini::forward
