#pragma once
#include "base/progress.h"
#include "control/reduced_problem.h"
#include <optional>

namespace signorini {

/// A scene made ready to simulate: the modules by value, in the order in which they depend on each other.
struct Problem {
  /// Collective. Throws UserError, SolverFailure.
  Problem(MPI_Comm comm, const scene::Scene& scene, forward::Stepper::Needs needs, Timers& timers);
  Problem(const Problem&) = delete;
  Problem& operator=(const Problem&) = delete;

  const scene::Scene& scene;
  Timers& timers;
  mesh::Mesh mesh;
  fem::Space space;
  fem::Operators operators;
  forward::Stepper stepper;
  forward::Initial initial;
  std::optional<forward::SceneLoad> scene_load;

  /// The scene's loads, null if it has none.
  [[nodiscard]] const forward::Load* scene_loads() const { return scene_load ? &*scene_load : nullptr; }
  /// All that acts on the body: the scene's loads and, if given, a control's, which must outlive it. Collective.
  [[nodiscard]] forward::ForceAtStep load(const forward::Load* control = nullptr) const {
    return {space, {scene_loads(), control}};
  }
  [[nodiscard]] int steps() const { return scene.time.steps; }
  /// Unknowns that no clamp holds, on all ranks. Collective.
  [[nodiscard]] long free_dofs() const;
};

/// The control that a scene gives (control.initial, within its bounds), for runs that do not look for one.
class GivenControl {
public:
  /// Collective. `problem` must outlive this object. Throws UserError.
  explicit GivenControl(const Problem& problem);
  GivenControl(const GivenControl&) = delete;
  GivenControl& operator=(const GivenControl&) = delete;

  /// All that acts, the control included; valid as long as this object lives.
  [[nodiscard]] forward::ForceAtStep load() const;

private:
  const Problem& problem_;
  std::optional<control::ControlSpace> controls_;
  std::optional<control::Control> control_;
  std::optional<control::ControlForce> force_; ///< of control_
};

/// The scene's control and objective on top of it.
struct ControlProblem {
  /// Computes the desired states, for which a reference control is simulated. Collective. Throws UserError,
  /// SolverFailure, Interrupted.
  ControlProblem(const Problem& problem, const Console& console);
  ControlProblem(const ControlProblem&) = delete;
  ControlProblem& operator=(const ControlProblem&) = delete;

  control::ControlSpace controls;
  std::optional<control::Control> reference; ///< the control whose state is desired, if the scene names one
  /// The budget of the scene is for the motions of controls, of which one is looked at at a time; where the desired motion
  /// is a computed one, that has half of it.
  forward::Storage storage, desired_storage;
  control::Objective objective;
  control::ReducedProblem reduced;

  /// The scene's first guess.
  [[nodiscard]] control::Control first_guess(const scene::Scene& scene) const;
};

} // namespace signorini
