// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "problem/problem.h"

namespace signorini::problem {

/// J of a motion that is simulated under the scene's given control, sampled frame by frame, even if its steps
/// are chosen during the run. A desired motion of a control is simulated beside it; at most two states of
/// either are in memory.
class RunObjective {
public:
  /// The scene must have an objective. Collective. The references must outlive this object. Throws UserError.
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
  control::ControlSpace controls_; ///< space of the reference control
  control::ObservedSet observed_;
  std::unique_ptr<const step::Displacements> desired_;
  std::vector<double> squared_distances_;
};

} // namespace signorini::problem
