// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "problem/problem.h"

namespace signorini::problem {

/// Computes the objective J of a simulation under the scene's given control, frame by frame. Step lengths may
/// be chosen during the simulation. A desired motion under a reference control is simulated alongside, with
/// two of its states in memory.
class RunObjective {
public:
  /// Prepares the desired motion; the scene must have an objective. Throws UserError. Collective. The
  /// references must outlive this object.
  RunObjective(const Problem& problem, const GivenControl& given);
  RunObjective(const RunObjective&) = delete;
  RunObjective& operator=(const RunObjective&) = delete;

  /// Adds a frame of the simulation; must be called for all frames 0…N in order. Throws UserError,
  /// SolverFailure. Collective.
  void observe(const trajectory::Frame& frame);

  /// The objective J; valid after the last frame, when the problem's time steps are complete. Collective.
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
