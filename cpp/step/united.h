// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "step/step.h"

namespace signorini::step {

/// Scope in which the tasks of a Lockstep make the solves and products of steps of one length together.
class United {
public:
  /// `tau`: length of the steps, s. The references must outlive this object. Collective.
  United(const Stepper& stepper, double tau, Lockstep& lockstep)
      : stepper_(stepper), tau_(tau), solves_(stepper.unite(tau, &lockstep)) {}
  ~United() { (void)stepper_.unite(tau_, nullptr); }
  United(const United&) = delete;
  United& operator=(const United&) = delete;
  /// Whether the solver makes solves together.
  [[nodiscard]] bool solves() const { return solves_; }

private:
  const Stepper& stepper_;
  double tau_;
  bool solves_;
};

} // namespace signorini::step
