// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/scenario_problem.h"
#include "problem/motion_set.h"

namespace signorini::problem {

/// Problems of a scene's scenarios for one control space. All members are collective.
class Scenarios {
public:
  /// Sets up the problems. `objective`: of the scene itself. Throws UserError, SolverFailure, Interrupted.
  /// The references must outlive this object.
  Scenarios(const Problem& nominal, const control::ControlSpace& controls,
            const control::Objective& objective);

  /// Creates the problem of J over all scenarios; this object must outlive it. `model`: of the scene itself.
  [[nodiscard]] std::unique_ptr<control::ScenarioProblem> reduced(const control::Model& model);

  /// Returns the number in ScenarioProblem of the i-th scenario; 0: the scene itself.
  [[nodiscard]] std::size_t number(std::size_t i) const { return numbers_[i]; }

private:
  const Problem& nominal_;
  const control::ControlSpace& controls_;
  const control::Objective& objective_;
  MotionSet others_; ///< of the scenarios that change the scene
  std::vector<std::size_t> numbers_;
};

/// Number of motions over which J of a scene is computed: its own, and one for each scenario that changes it.
[[nodiscard]] std::size_t motions(const scene::Scene& scene);

} // namespace signorini::problem
