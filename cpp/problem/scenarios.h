// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/scenario_problem.h"
#include "problem/problem.h"

namespace signorini::problem {

/// Problems of a scene's scenarios for one control space. Scenarios with equal step operators D share them
/// and their factorisation, and make their steps together. All members are collective.
class Scenarios {
public:
  /// Sets up the problems. `objective`: of the scene itself; a desired motion under a reference control is
  /// that of the scene itself. Throws UserError, SolverFailure, Interrupted. The references must outlive this
  /// object.
  Scenarios(const Problem& nominal, const control::ControlSpace& controls,
            const control::Objective& objective);
  ~Scenarios();

  /// Creates the problem of J over all scenarios; this object must outlive it. `model`: of the scene itself.
  [[nodiscard]] std::unique_ptr<control::ScenarioProblem> reduced(const control::Model& model);

  /// Returns the number in ScenarioProblem of the i-th scenario; 0: the scene itself.
  [[nodiscard]] std::size_t number(std::size_t i) const { return numbers_[i]; }

private:
  struct Parts;
  /// Runs tasks, together as far as their solvers admit it.
  void run(const std::vector<std::function<void()>>& tasks);

  const Problem& nominal_;
  const control::ControlSpace& controls_;
  const control::Objective& objective_;
  std::vector<std::unique_ptr<Parts>> parts_; ///< of the scenarios other than the scene itself
  std::vector<std::size_t> numbers_;
  std::vector<const step::Stepper*> shared_; ///< of each D that several scenarios share
  Lockstep lockstep_;
};

/// Number of motions over which J of a scene is computed: its own, and one for each scenario that changes it.
[[nodiscard]] std::size_t motions(const scene::Scene& scene);

} // namespace signorini::problem
