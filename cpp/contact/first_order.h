// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/lcp/complementarity.h"
#include <memory>

namespace signorini::contact {

/// Contact laws with friction to first order at the solution of a step, for one-sided derivatives
/// (docs/method.md section 4). Weak candidates obey an inequality between δρ and δU: one that touches without
/// force opens, sticks or slips, one at the limit of sticking sticks or slips. The others obey their
/// linearised laws.
class FirstOrderLaws {
public:
  /// `contact`: of the step. `rows` must outlive this object.
  FirstOrderLaws(const ConstraintRows& rows, const ContactLinearisation& contact);

  /// Law of each group.
  [[nodiscard]] const std::vector<const Law*>& laws() const { return laws_; }
  /// Friction of each group, as ContactState::friction.
  [[nodiscard]] const std::vector<double>& friction() const { return friction_; }

  /// Replaces the active set, the forces and the equations of `contact`, that of the constructor, by those on
  /// which the derivative `change` is linear: its δρ and δU satisfy the equations. `scales`: of the rows.
  void select(const ContactState& change, const Complementarity& scales, ContactLinearisation& contact) const;

private:
  const ConstraintRows& rows_;
  std::vector<std::unique_ptr<const Law>> own_;
  std::vector<const Law*> laws_;
  std::vector<double> friction_;
};

} // namespace signorini::contact
