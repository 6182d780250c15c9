// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "problem/motion_set.h"
#include <functional>
#include <span>

namespace signorini::problem {

/// Motions of one scene under several controls, made together where its solver admits it. All members are
/// collective.
class MotionBlock {
public:
  /// Largest number of motions that are made together.
  static constexpr std::size_t largest = 16;

  /// The references must outlive this object.
  MotionBlock(const Problem& problem, ControlProblem& control_problem);

  /// Whether motions are made together: with a direct solver on one rank, steps of equal length, and one
  /// motion for each control.
  [[nodiscard]] bool unites() const { return unites_; }

  /// Calls `compute(i, reduced)` for all controls. `reduced` has no trial, and only the call may use it;
  /// unless unites(), it is the scene's own reduced problem, whose trial is then overwritten. Throws
  /// SolverFailure, Interrupted.
  void run(std::span<const control::Control> controls,
           const std::function<void(std::size_t i, control::ReducedProblem& reduced)>& compute);

private:
  const Problem& problem_;
  ControlProblem& control_problem_;
  bool unites_;
  std::optional<MotionSet> motions_; ///< absent before the first use
};

} // namespace signorini::problem
