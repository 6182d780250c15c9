// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/lcp/complementarity.h"
#include "base/error.h"
#include "contact/lcp/primal_dual.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace signorini::contact {
using petsc::check;

namespace {

/// Relative error of the displacements from a solve: rounding error plus the error due to an iterative
/// solver. The rounding error is taken as 1e3 times the machine epsilon, more than the backward error of
/// factorisations. The solver's tolerance, which bounds the energy norm, is multiplied by a factor, since a
/// single node may have a larger error.
double accuracy(double tolerance) {
  constexpr double rounding = 1e3 * std::numeric_limits<double>::epsilon(), share = 100;
  return rounding + share * tolerance;
}

/// Multipliers, gaps and law of a group.
struct Values {
  const Law& law;
  std::size_t size;
  std::array<double, 3> multipliers, gaps;
  double friction;

  Values(const ConstraintRows& rows, int group, const ContactState& state)
      : law(rows.law(group)), size(rows.size(group)), multipliers(rows.of_group(group, state.lambda)),
        gaps(rows.of_group(group, state.gap)), friction(state.friction_of(static_cast<std::size_t>(group))) {}
  [[nodiscard]] std::span<const double> rho() const { return {multipliers.data(), size}; }
  [[nodiscard]] std::span<const double> U() const { return {gaps.data(), size}; }
};

} // namespace

Complementarity::Complementarity(const ConstraintRows& rows, double diameter, Vec diagonal)
    : rows_(rows), diameter_(diameter), gap_tolerance_(gap_tolerance(diameter)) {
  // Σ_j h_j² D_jj is the stiffness against moving the row's dofs alone along its force, if D's entries that
  // couple them are neglected.
  multiplier_per_motion_ = rows.weighted_squares(diagonal);
}

Compliance Complementarity::compliance(int candidate) const {
  double tangential = 0;
  const std::size_t k = rows_.size(candidate);
  for (std::size_t c = 1; c < k; ++c)
    tangential += 1 / (multiplier_per_motion_[rows_.row(candidate, c)] * static_cast<double>(k - 1));
  return {1 / multiplier_per_motion_[candidate], tangential};
}

std::vector<Compliance> Complementarity::compliances() const {
  std::vector<Compliance> all;
  for (int i = 0; i < rows_.groups(); ++i)
    all.push_back(compliance(i));
  return all;
}

double Complementarity::negligible_gap(double deepest_gap, double displacement) const {
  constexpr double relative = 1e-10; // rounding of S times its condition number, as below
  return std::max(std::min(gap_tolerance_, relative * deepest_gap), accuracy(0) * displacement);
}

double Complementarity::negligible_motion(std::span<const double> lambda, double size,
                                          double tolerance) const {
  double largest = 0;
  for (int i = 0; i < rows_.groups(); ++i)
    largest = std::max(largest, lambda[i] / multiplier_per_motion_[i]);
  // Forces follow from gaps by S⁻¹, whose rounding is that of S times its condition number, up to 1e6 for a
  // stiff body without clamps; the residual r − D y is known to the accuracy of its terms.
  constexpr double relative = 1e-10;
  constexpr double underflow = // below which numbers have fewer digits, as the begin of a smooth load may be
      std::numeric_limits<double>::min() / std::numeric_limits<double>::epsilon();
  return relative * largest + accuracy(tolerance) * size + underflow;
}

void Complementarity::classify(ContactState& state, Vec y, double tolerance, double residual) const {
  const auto finite = [](double x) { return std::isfinite(x); };
  if (!std::ranges::all_of(state.gap, finite) || !std::ranges::all_of(state.lambda, finite))
    throw SolverFailure("the solution is not finite");
  std::ranges::fill(state.status, Status::open);
  state.active.clear();
  state.forces.clear();
  state.equations.clear();
  state.weak.clear();
  if (!rows_.act_open() &&
      std::ranges::all_of(state.normal_gap(), [&](double g) { return g > gap_tolerance_; }) &&
      std::ranges::all_of(state.lambda, [](double force) { return force == 0; }))
    return;
  PetscReal size = 0;
  check(VecNorm(y, NORM_INFINITY, &size));
  // A residual of the laws allows forces that move their node by twice as much, as a normal and as a
  // tangential force.
  const double motion =
      std::max(negligible_motion(state.lambda, size, tolerance), std::min(2 * residual, gap_tolerance_));
  // Gaps are differences of positions, known to the rounding of coordinates.
  const double closed = std::min(gap_tolerance_, accuracy(tolerance) * (diameter_ + size));
  double penetration = 0, adhesion = 0, distance = 0;
  const auto values = [&](int i) { return Values{rows_, i, state}; };
  for (int i = 0; i < rows_.groups(); ++i) {
    penetration = std::max(penetration, -state.gap[i]);
    adhesion = std::max(adhesion, -state.lambda[i] / multiplier_per_motion_[i]);
    const Values group = values(i);
    state.status[i] = group.law.status(group.rho(), group.U(), motion * multiplier_per_motion_[i], closed);
    if (state.status[i] == Status::strong) {
      distance = std::max(distance, state.gap[i]);
      state.active.push_back(i);
    }
  }
  if (!holds_to(gap_tolerance_, motion, state))
    throw SolverFailure(fmt::format("the contact solution is not complementary. The largest penetration is "
                                    "{:.3e} m, the largest gap with a force {:.3e} m (limit of both: {:.3e} "
                                    "m). Pulling forces move a node by {:.3e} m (limit {:.3e} m); {} of {} "
                                    "candidates are strongly active",
                                    penetration, distance, gap_tolerance_, adhesion, motion,
                                    state.count(Status::strong), rows_.groups()));
  for (int i = 0; i < rows_.groups(); ++i)
    if (state.status[i] == Status::weak && depends(rows_, state.active, i))
      // This candidate cannot open while those with forces on which it depends are closed, and part of their
      // force may be assigned to it.
      state.status[i] = Status::strong;
  state.active.clear();
  for (int i = 0; i < rows_.groups(); ++i) {
    const bool open = state.status[i] == Status::open, weak = state.status[i] == Status::weak;
    if (open && !rows_.law(i).acts_open())
      continue;
    const Values group = values(i);
    state.active.push_back(i);
    state.forces.insert(state.forces.end(), group.rho().begin(), group.rho().end());
    bool limit = false;
    if (!rows_.symmetric()) {
      const Compliance own = compliance(i);
      LawEquation& law = state.equations.emplace_back(
          group.law.linearised(group.rho(), group.U(), own, group.friction, closed));
      law.weak = weak;
      law.limit = law.limit && (!weak || group.law.acts_open()); // else it is about to open too
      if (open)
        law.open(own.normal);
      limit = law.limit;
    }
    if (weak || limit)
      state.weak.push_back(i);
  }
}

bool Complementarity::holds_to(double negligible, double motion, const ContactState& state) const {
  for (int i = 0; i < rows_.groups(); ++i) {
    const Values group{rows_, i, state};
    if (!group.law.holds(group.rho(), group.U(), group.friction, motion * multiplier_per_motion_[i],
                         negligible))
      return false;
  }
  return true;
}

} // namespace signorini::contact
