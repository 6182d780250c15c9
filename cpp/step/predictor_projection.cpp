// SPDX-License-Identifier: GPL-3.0-or-later
#include "step/predictor_projection.h"
#include "contact/lcp/primal_dual.h"
#include <algorithm>
#include <utility>
#include <vector>

namespace signorini::step {
using petsc::check;

namespace {

petsc::Matrix decoupled(petsc::Matrix M, const fem::DirichletDofs& clamped) {
  clamped.decouple(M);
  return M;
}

} // namespace

PredictorProjection::PredictorProjection(petsc::Matrix blocks, Mat M, const fem::DirichletDofs& clamped,
                                         const contact::ContactPairs& pairs, const scene::Solver& scene,
                                         bool derivatives, double solves)
    : M_(M), clamped_(clamped), pairs_(pairs),
      solver_(decoupled(std::move(blocks), clamped), &pairs, scene, derivatives, solves),
      zero_(petsc::vector_of(M)) {}

PredictorProjection::PredictorProjection(const PredictorProjection& like, Mat M,
                                         const fem::DirichletDofs& clamped,
                                         const contact::ContactPairs& pairs, bool same_rows,
                                         const scene::Solver& scene)
    : M_(M), clamped_(clamped), pairs_(pairs), solver_(like.solver_, &pairs, same_rows, scene, {}),
      zero_(petsc::vector_of(M)) {}

PredictorProjection::Workspace PredictorProjection::workspace() const {
  return {.r = petsc::zero_like(zero_),
          .jump = petsc::zero_like(zero_),
          .gap = std::vector<double>(static_cast<std::size_t>(pairs_.rows().count())),
          .gap_before = std::vector<double>(static_cast<std::size_t>(pairs_.rows().count())),
          .contact = contact::ContactState(pairs_.count(), pairs_.rows().count()),
          .solver = solver_.contact()->workspace()};
}

Vec PredictorProjection::jump(std::span<const double> psi, Vec x, const contact::ActiveSet& previous,
                              contact::ActiveSet& set, Workspace& work) const {
  set.clear();
  pairs_.rows().gap(psi, x, work.gap);
  if (std::ranges::all_of(work.gap, [&](double g) { return g >= -pairs_.gap_tolerance(); }))
    return nullptr;
  check(VecZeroEntries(work.jump));
  const contact::ContactProblem projection{zero_, work.gap, previous, work.contact, work.jump};
  solver_.contact()->solve(projection, work.solver);
  set = work.contact.active;
  return work.jump;
}

void PredictorProjection::find_weak(contact::ContactState& contact, bool projected,
                                    std::span<const double> psi, Vec before,
                                    const contact::ContactLinearisation& previous, Workspace& work) const {
  contact.predictor_weak.clear();
  bool measured = false;
  // Where a body rests on an obstacle the predictor touches in every step, and a change keeps it there.
  const auto arrived = [&](int i) {
    if (std::ranges::binary_search(previous.active, i))
      return false;
    if (!std::exchange(measured, true))
      pairs_.rows().gap(psi, before, work.gap_before);
    return work.gap_before[static_cast<std::size_t>(i)] > pairs_.gap_tolerance();
  };
  for (int i = 0; i < pairs_.count(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    const bool touches =
        projected ? work.contact.status[at] == contact::Status::weak : work.gap[at] <= pairs_.gap_tolerance();
    if (touches && (contact.status[at] == contact::Status::weak || arrived(i)))
      contact.predictor_weak.push_back(i);
  }
  if (!projected)
    contact.predictor = contact.predictor_weak;
}

Vec PredictorProjection::one_sided_jump(contact::ActiveSet& set, const contact::ActiveSet& weak, Vec x,
                                        Workspace& work) const {
  const contact::ConstraintRows& rows = pairs_.rows();
  std::vector<double> force(static_cast<std::size_t>(rows.count())), motion(force.size());
  Vec jump = nullptr;
  PetscReal scale = 0;
  check(MatMult(M_, x, work.r));
  check(VecNorm(work.r, NORM_INFINITY, &scale));
  contact::close_to_first_order(rows, weak, set, force, motion, [&] {
    std::ranges::fill(force, 0);
    const Data data{.force = nullptr, .normal = {}, .multipliers = force};
    jump = linearised_jump(set, x, work, &data);
    check(VecCopy(x, work.r));
    if (jump)
      check(VecAXPY(work.r, 1, jump));
    rows.apply_transpose(work.r, motion);
    PetscReal largest_motion = 0;
    check(VecNorm(work.r, NORM_INFINITY, &largest_motion));
    return std::pair(scale, largest_motion);
  });
  return jump;
}

Vec PredictorProjection::linearised_jump(const contact::ActiveSet& set, Vec x, Workspace& work,
                                         const Data* data) const {
  if (set.empty())
    return nullptr;
  check(MatMult(M_, x, work.r));
  if (data && data->force)
    check(VecAXPY(work.r, 1, data->force));
  clamped_.clear(work.r);
  check(VecCopy(x, work.jump));
  contact::LinearisedContact projection{.r = work.r, .set = set, .x = work.jump};
  if (data) {
    const auto rows = static_cast<std::size_t>(pairs_.rows().count());
    projection.value = data->normal.first(std::min(rows, data->normal.size()));
    projection.multipliers = data->multipliers.first(std::min(rows, data->multipliers.size()));
  }
  solver_.contact()->solve_linearised(projection, work.solver);
  check(VecAXPY(work.jump, -1, x));
  return work.jump;
}

double PredictorProjection::bytes() const {
  const SolverChoice::Memory memory = solver_.memory();
  return memory.factor + memory.condensation;
}

} // namespace signorini::step
