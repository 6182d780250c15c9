// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "base/progress.h"
#include "control/reduced_problem.h"
#include "diagnostics/probes.h"
#include <optional>

namespace signorini::problem {

/// Mesh of a scene and the finite-element space on it. Unknown parameters change neither but the values of
/// virtual nodes, which are those at the scene's own values.
struct SpaceDiscretisation {
  /// Reads or generates the mesh of a scene. Throws UserError. Collective.
  SpaceDiscretisation(MPI_Comm comm, const scene::Scene& scene, Timers& timers,
                      const mesh::Meshing& meshing = {});

  mesh::Mesh mesh;
  fem::Space space;
};

/// A scene set up for simulation: discretisation, matrices, time stepper, initial state and loads.
struct Problem {
  /// Sets up the problem of a scene on a discretisation of its own. Throws UserError, SolverFailure,
  /// Interrupted. Collective.
  Problem(MPI_Comm comm, const scene::Scene& s, step::Stepper::Needs needs, Timers& t)
      : Problem(std::make_shared<const SpaceDiscretisation>(comm, s, t), s, needs, t) {}
  /// Sets up the problem of a scene on a discretisation that several problems share. `stops`: whether a
  /// request to stop throws Interrupted. `like`: a problem with the same operators_key(), whose operators and
  /// factorisations are used; it must outlive this object. Collective.
  Problem(std::shared_ptr<const SpaceDiscretisation> shared, const scene::Scene& s,
          step::Stepper::Needs needs, Timers& t, trajectory::Stops stops = trajectory::Stops::obeyed,
          const Problem* like = nullptr);
  Problem(const Problem&) = delete;
  Problem& operator=(const Problem&) = delete;

  const scene::Scene& scene;
  Timers& timers;
  std::shared_ptr<const SpaceDiscretisation> discretisation; ///< may be shared with other problems
  const mesh::Mesh& mesh;
  fem::Space space; ///< that of the discretisation, with the virtual nodes of `scene`
  std::shared_ptr<const fem::Operators> shared_operators; ///< may be shared with other problems
  const fem::Operators& operators;
  step::Stepper stepper;
  step::TimeGrid grid; ///< the time steps; steps of varying length are set by choose_steps() or a simulation
  step::State initial;
  std::optional<step::SceneLoad> scene_load;
  std::optional<diagnostics::Probes> probes; ///< absent if the scene has no probes
  step::Stepper::Needs needs;                ///< requirements with which the solvers were chosen

  /// The scene's loads; null if the scene has none.
  [[nodiscard]] const step::SceneLoad* scene_loads() const { return scene_load ? &*scene_load : nullptr; }
  /// All forces on the body: the scene's loads and the force of `control`, unless null. `control` must
  /// outlive the result. Collective.
  [[nodiscard]] step::ForceAtStep load(const step::Load* control = nullptr) const {
    return {space, {scene_loads(), control}};
  }
  [[nodiscard]] int steps() const { return grid.steps(); }
  /// Number of unknowns that are not clamped, on all ranks. Collective.
  [[nodiscard]] long free_dofs() const;
};

/// Requirements of a simulation on the solvers: derivatives, and the number of passes over all steps.
[[nodiscard]] step::Stepper::Needs simulation_needs(const scene::Scene& scene);
/// Requirements of one rung of a study on the solvers.
[[nodiscard]] step::Stepper::Needs study_needs(const scene::Scene& scene);
/// Requirements of the verb check on the solvers.
[[nodiscard]] step::Stepper::Needs check_needs(const scene::Scene& scene);
/// Requirements of a search for a control on the solvers.
[[nodiscard]] step::Stepper::Needs search_needs(const scene::Scene& scene);
/// Requirements of one evaluation of a fit on the solvers.
[[nodiscard]] step::Stepper::Needs fit_needs(const scene::Scene& scene);

/// Returns the factory of the stores for the states of motions, as the scene's [trajectory] selects. If the
/// desired motion is computed from a reference control, the factory may use only half of trajectory.budget:
/// the other half is for a second factory, for the states of the desired motion. `motions`: number of
/// factories that divide the budget.
[[nodiscard]] trajectory::StateStoreFactory state_stores(const Problem& problem, std::size_t motions = 1);

/// Desired motion of a scene that gives it by expressions or by an earlier run. `keep`: whether to keep all
/// states in memory. Throws UserError. Collective. `problem` must outlive the result.
std::unique_ptr<const step::Displacements> given_motion(const Problem& problem, bool keep);

/// Returns a warning if the desired motion is that of an earlier run whose stored states are farther apart in
/// time than 1.5 steps of this run. Collective.
std::optional<Warning> desired_run_spacing_warning(const Problem& problem);

/// Control that a scene gives by control.initial, clipped to the bounds, for runs that do not optimise. If
/// the control is constant on each time step and step lengths are chosen during the motion, the control is
/// evaluated step by step.
class GivenControl {
public:
  /// Reads or interpolates the control. Throws UserError. Collective. `problem` must outlive this object.
  explicit GivenControl(const Problem& problem);
  GivenControl(const GivenControl&) = delete;
  GivenControl& operator=(const GivenControl&) = delete;

  /// Whether the scene gives a control other than zero.
  [[nodiscard]] bool acts() const { return force_ != nullptr; }

  /// The force of the control; null if acts() is false.
  [[nodiscard]] const step::Load* control_force() const { return force_.get(); }
  /// All forces on the body: the scene's loads and the force of the control. Valid as long as this object.
  [[nodiscard]] step::ForceAtStep load() const;

  /// The control as an element of the space `controls`; zero if acts() is false. Throws UserError.
  /// Collective.
  [[nodiscard]] control::Control control(const control::ControlSpace& controls) const;

private:
  const Problem& problem_;
  std::optional<control::ControlSpace> controls_;
  std::optional<control::Control> control_;
  std::unique_ptr<const step::Load> force_;
};

/// Chooses the time steps of a problem with varying step lengths, unless they are set already. Simulates a
/// preliminary motion under the control that the scene gives, else under the reference control. Call this
/// before constructing objects that refer to the steps. Throws UserError, SolverFailure, Interrupted.
/// Collective.
void choose_steps(Problem& problem, const Console& console);
/// Chooses the time steps of a problem with varying step lengths, even if they are set already. Simulates a
/// preliminary motion under `load`. Throws SolverFailure, Interrupted. Collective.
void choose_steps(Problem& problem, const step::ForceAtStep& load, const Console& console);
/// Chooses the time steps of a problem with varying step lengths, even if they are set already. Simulates a
/// preliminary motion under u, a control of the space `from`, which has other steps or another mesh. Throws
/// UserError, SolverFailure, Interrupted. Collective.
void choose_steps(Problem& problem, const control::ControlSpace& from, const control::Control& u,
                  const Console& console);

class Scenarios;

/// Optimal-control problem of a scene: control space, objective, desired motion and reduced problem.
struct ControlProblem {
  /// Computes the desired states, by a simulation under the reference control if the scene has one. Throws
  /// UserError, SolverFailure, Interrupted. Collective.
  ControlProblem(const Problem& problem, const Console& console);
  ControlProblem(const ControlProblem&) = delete;
  ControlProblem& operator=(const ControlProblem&) = delete;
  ~ControlProblem();

  control::ControlSpace controls;
  std::optional<control::Control> reference; ///< the reference control; absent if the scene has none
  /// Factories of the stores for the states: of motions under controls, and of the desired motion.
  trajectory::StateStoreFactory storage, desired_storage;
  control::Objective objective;
  std::unique_ptr<Scenarios> scenarios; ///< null if the scene has none
  std::unique_ptr<control::ReducedProblem> owned;
  control::ReducedProblem& reduced; ///< *owned; with scenarios a control::ScenarioProblem

  /// The scene's first guess, clipped to the bounds. Throws UserError. Collective.
  [[nodiscard]] control::Control first_guess(const scene::Scene& scene) const;
};

} // namespace signorini::problem
