// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "problem/problem.h"

namespace signorini::problem {

/// Optimisation problem for the unknown parameters of a scene, alone or together with a control. Consists of
/// the misfit to the measurements and of the reduced problem. The models for different parameter values share
/// the mesh and the choice of solvers.
class ParameterProblem {
public:
  /// Reads the data of the measurements. `control`: problem of the control that is sought too; null: none.
  /// Throws UserError. Collective. The references must outlive this object.
  ParameterProblem(std::shared_ptr<const SpaceDiscretisation> discretisation, const scene::Scene& scene,
                   Timers& timers, const ControlProblem* control = nullptr);
  ParameterProblem(const ParameterProblem&) = delete; // its parts refer to each other
  ParameterProblem& operator=(const ParameterProblem&) = delete;

  const scene::Scene& scene;
  std::shared_ptr<const SpaceDiscretisation> discretisation;
  control::Misfit misfit;
  control::ReducedProblem reduced;

  /// The scene with the parameters x, which are scaled as the optimiser varies them (Misfit::values()).
  [[nodiscard]] scene::Scene scene_at(std::span<const double> x) const {
    return scene::with_values(scene, misfit.values(x));
  }
  /// Whether a control is sought too.
  [[nodiscard]] bool seeks_control() const { return seeks_control_; }
  /// Requirements on the solvers at any x. After the first model they keep its choice of the linear solver.
  [[nodiscard]] step::Stepper::Needs needs() const;

private:
  /// Sets up the model for the parameters x. `columns`: number of columns of control::Measurements; `stops`:
  /// whether a request to stop throws Interrupted. Throws UserError if the scene with x is invalid.
  /// Collective.
  control::Model model(std::span<const double> x, std::size_t columns, trajectory::Stops stops);

  Timers& timers_;
  bool seeks_control_;
  std::optional<bool> iterative_; ///< whether systems with D are solved iteratively; absent: undecided
};

} // namespace signorini::problem
