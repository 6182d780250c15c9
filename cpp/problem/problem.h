// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "control/reduced_problem.h"
#include "diagnostics/probes.h"
#include <optional>

namespace signorini::problem {

/// Mesh of a scene and the functions on it, independent of all unknown parameters.
struct Discretisation {
  /// Collective. Throws UserError.
  Discretisation(MPI_Comm comm, const scene::Scene& scene, Timers& timers, const mesh::Meshing& meshing = {});

  mesh::Mesh mesh;
  fem::Space space;
};

/// A scene set up for simulation: the modules by value, in the order of their dependence.
struct Problem {
  /// Collective. Throws UserError, SolverFailure, Interrupted.
  Problem(MPI_Comm comm, const scene::Scene& s, step::Stepper::Needs needs, Timers& t)
      : Problem(std::make_shared<const Discretisation>(comm, s, t), s, needs, t) {}
  /// Sets the problem up on a discretisation that several problems share.
  Problem(std::shared_ptr<const Discretisation> shared, const scene::Scene& s, step::Stepper::Needs needs,
          Timers& t, trajectory::Stops stops = trajectory::Stops::obeyed);
  Problem(const Problem&) = delete;
  Problem& operator=(const Problem&) = delete;

  const scene::Scene& scene;
  Timers& timers;
  std::shared_ptr<const Discretisation> discretisation; ///< may be shared with other problems
  const mesh::Mesh& mesh;
  const fem::Space& space;
  fem::Operators operators;
  step::Stepper stepper;
  step::TimeGrid grid; ///< the steps; none until choose_steps() where their lengths vary
  step::State initial;
  std::optional<step::SceneLoad> scene_load;
  std::optional<diagnostics::Probes> probes; ///< absent if the scene has none

  /// The scene's loads, null if it has none.
  [[nodiscard]] const step::SceneLoad* scene_loads() const { return scene_load ? &*scene_load : nullptr; }
  /// All forces on the body: the scene's loads and, if given, a control's, which must outlive the result.
  /// Collective.
  [[nodiscard]] step::ForceAtStep load(const step::Load* control = nullptr) const {
    return {space, {scene_loads(), control}};
  }
  [[nodiscard]] int steps() const { return grid.steps(); }
  /// Number of unknowns that are not clamped, on all ranks. Collective.
  [[nodiscard]] long free_dofs() const;
};

/// Requirements of each verb on the solvers, if known before it starts.
[[nodiscard]] step::Stepper::Needs simulation_needs(const scene::Scene& scene);
[[nodiscard]] step::Stepper::Needs study_needs(const scene::Scene& scene); ///< needs of a rung
[[nodiscard]] step::Stepper::Needs check_needs(const scene::Scene& scene);
[[nodiscard]] step::Stepper::Needs search_needs(const scene::Scene& scene);
[[nodiscard]] step::Stepper::Needs fit_needs(const scene::Scene& scene); ///< needs of one evaluation

/// Stores of the states of motions, those of controls or of the desired one. If the latter is computed, each
/// kind may use half of the scene's budget.
[[nodiscard]] trajectory::StateStoreFactory state_stores(const Problem& problem);

/// Desired motion of a scene, given by expressions or by a run; `keep`: whether all of its states are kept in
/// memory. Collective. `problem` must outlive it. Throws UserError.
std::unique_ptr<const step::Displacements> given_motion(const Problem& problem, bool keep);

/// Warns if a run whose motion is desired stored fewer states than this run has. Collective.
std::optional<Warning> desired_warning(const Problem& problem);

/// Control that a scene gives (control.initial, within its bounds), for runs that do not optimise. If the
/// lengths of steps are still to be chosen and it is constant on each step, it is evaluated step by step.
class GivenControl {
public:
  /// Collective. `problem` must outlive this object. Throws UserError.
  explicit GivenControl(const Problem& problem);
  GivenControl(const GivenControl&) = delete;
  GivenControl& operator=(const GivenControl&) = delete;

  /// Whether there is a control.
  [[nodiscard]] bool acts() const { return force_ != nullptr; }

  /// The control's force, null without one.
  [[nodiscard]] const step::Load* force() const { return force_.get(); }
  /// All forces on the body, the control's included; valid as long as this object lives.
  [[nodiscard]] step::ForceAtStep load() const;

  /// The control on the steps of `controls`, zero where the scene gives none. Collective. Throws UserError.
  [[nodiscard]] control::Control control(const control::ControlSpace& controls) const;

private:
  const Problem& problem_;
  std::optional<control::ControlSpace> controls_;
  std::optional<control::Control> control_;
  std::unique_ptr<const step::Load> force_;
};

/// Sets the steps of the problem, if their lengths vary and are not known yet, by a motion under a control:
/// the one that the scene gives or, without one, that of the desired motion. Objects that refer to the steps
/// must be made afterwards. Collective. Throws UserError, SolverFailure, Interrupted.
void choose_steps(Problem& problem, const Console& console);
/// Sets the steps by a motion under `load`, whether or not they are known.
void choose_steps(Problem& problem, const step::ForceAtStep& load, const Console& console);
/// Sets the steps by a motion under a control of other steps, or of another mesh.
void choose_steps(Problem& problem, const control::ControlSpace& from, const control::Control& u,
                  const Console& console);

/// Control problem of a scene: control, objective, desired motion and reduced problem.
struct ControlProblem {
  /// Computes the desired states, by simulating the reference control if there is one. Collective. Throws
  /// UserError, SolverFailure, Interrupted.
  ControlProblem(const Problem& problem, const Console& console);
  ControlProblem(const ControlProblem&) = delete;
  ControlProblem& operator=(const ControlProblem&) = delete;

  control::ControlSpace controls;
  std::optional<control::Control> reference; ///< the control whose state is desired, if the scene names one
  /// Stores for the motions of controls, of which one is read at a time, and for the desired motion.
  trajectory::StateStoreFactory storage, desired_storage;
  control::Objective objective;
  control::ReducedProblem reduced;

  /// The scene's first guess, within the bounds.
  [[nodiscard]] control::Control first_guess(const scene::Scene& scene) const;
};

} // namespace signorini::problem
