// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "problem/problem.h"

namespace signorini::problem {

/// Problem of a scene's parameters: their misfit and the reduced problem, with a control beside them where
/// `control` is given. The models at all values share the mesh and the choice of solvers.
class ParameterProblem {
public:
  /// Reads the data. Collective. The references must outlive this object. Throws UserError.
  ParameterProblem(std::shared_ptr<const Discretisation> discretisation, const scene::Scene& scene,
                   Timers& timers, const ControlProblem* control = nullptr);
  ParameterProblem(const ParameterProblem&) = delete; // its parts refer to each other
  ParameterProblem& operator=(const ParameterProblem&) = delete;

  const scene::Scene& scene;
  std::shared_ptr<const Discretisation> discretisation;
  control::Misfit misfit;
  control::ReducedProblem reduced;

  /// The scene with the parameters x.
  [[nodiscard]] scene::Scene scene_at(std::span<const double> x) const {
    return scene::with_values(scene, misfit.values(x));
  }
  /// Whether a control is sought too.
  [[nodiscard]] bool seeks_control() const { return seeks_control_; }
  /// Needs of the problem at any x; solvers are chosen once.
  [[nodiscard]] step::Stepper::Needs needs() const;

private:
  /// Sets up the model at x. Collective. Throws UserError if the scene is invalid there.
  control::Model model(std::span<const double> x, std::size_t columns, trajectory::Stops stops);

  Timers& timers_;
  bool seeks_control_;
  std::optional<bool> iterative_; ///< whether D is not factorised, once that is decided
};

} // namespace signorini::problem
