// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "problem/problem.h"

namespace signorini::problem {

/// J along a motion that is simulated under the scene's given control, sampled frame by frame, also where its
/// steps are chosen on the way. A desired motion that a control makes is simulated beside it: of either no
/// more than two states are in memory.
class RunObjective {
public:
  /// For a scene with an objective. Collective. The references must outlive this object. Throws UserError.
  RunObjective(const Problem& problem, const GivenControl& given);
  RunObjective(const RunObjective&) = delete;
  RunObjective& operator=(const RunObjective&) = delete;

  /// Takes the frames 0…N one after another. Collective. Throws UserError, SolverFailure.
  void observe(const trajectory::Frame& frame);

  /// J, once all frames have been taken and the problem has all its steps. Collective.
  [[nodiscard]] control::ObjectiveValue value() const;

private:
  const Problem& problem_;
  const GivenControl& given_;
  control::ControlSpace controls_; ///< of the reference control
  control::ObservedSet observed_;
  std::unique_ptr<const step::Displacements> desired_;
  std::vector<double> squared_distances_;
};

} // namespace signorini::problem
