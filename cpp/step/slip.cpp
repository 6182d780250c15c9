// SPDX-License-Identifier: GPL-3.0-or-later
// Steps with friction: the slip of a step depends on the displacement at its start.
#include "base/text.h"
#include "contact/solver/law_solver.h"
#include "step/step.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::step {
using petsc::check;

std::string Stepper::described(const contact::LawFailure& failure) const {
  const std::string where =
      fmt::format("{}, at the node at {}", failure.what(),
                  point_text(&pairs_->points()[3 * static_cast<std::size_t>(failure.group)]));
  if (pairs_->rows().law(failure.group).acts_open()) // whose solution is unique
    return where + "; shorten the steps";
  return fmt::format("{} with the coefficient of friction {:.4g}{}", where, failure.friction,
                     failure.friction < failure.critical
                         ? "; shorten the steps"
                         : fmt::format(". From {:.4g} on several forces are possible there, or none can be "
                                       "reached; shorten the steps or lower the coefficient",
                                       failure.critical));
}

void Stepper::set_slip_gaps(const StepInput& in, std::span<const double> psi, Workspace& work) const {
  const auto m = static_cast<std::size_t>(pairs_->count());
  pairs_->obstacle_ways(in.step.begin, in.step.end, work.slip_gaps);
  pairs_->rows().apply_transpose(in.from.y(), work.motion);
  for (std::size_t row = m; row < work.motion.size(); ++row)
    work.slip_gaps[row] += work.motion[row];
  std::ranges::copy(psi, work.slip_gaps.begin());
}

std::span<const double> Stepper::with_slip(std::span<const double> value, const State& from,
                                           Workspace& work) const {
  if (!frictional())
    return value;
  const contact::ConstraintRows& rows = pairs_->rows();
  rows.apply_transpose(from.y(), work.motion);
  for (std::size_t i = 0; i < work.motion.size(); ++i)
    work.slip_gaps[i] =
        (value.empty() ? 0 : value[i]) + (i < static_cast<std::size_t>(rows.groups()) ? 0 : work.motion[i]);
  return work.slip_gaps;
}

AdjointState Stepper::adjoint_state() const {
  AdjointState state(space_.vector(), branches());
  if (frictional())
    state.slip = space_.vector();
  return state;
}

void Stepper::solve_one_sided_slip(const LinearisedStep& step, contact::ContactLinearisation& contact,
                                   Workspace& work) const {
  const contact::ActiveSet set = contact.active;
  const contact::LinearisedContact one{.r = work.r,
                                       .set = set,
                                       .value = with_slip(step.normal, step.from, work),
                                       .x = step.to.y(),
                                       .multipliers = step.multipliers,
                                       .law = step.law};
  contact_solver(of_length(step.scheme.tau), work)->solve_one_sided(one, contact, *work.contact);
}

void Stepper::set_slip_dual(std::span<const double> mu, Vec dual, Workspace& work) const {
  std::ranges::copy(mu, work.motion.begin());
  std::fill_n(work.motion.begin(), pairs_->count(), 0.0);
  check(VecZeroEntries(dual));
  pairs_->rows().apply(1, work.motion, dual);
}

} // namespace signorini::step
