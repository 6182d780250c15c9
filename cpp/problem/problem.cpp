// SPDX-License-Identifier: GPL-3.0-or-later
#include "problem/problem.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/machine.h"
#include "base/signals.h"
#include "control/interpolation.h"
#include "io/field_reader.h"
#include "io/stored_control.h"
#include "problem/operators_key.h"
#include "problem/scenarios.h"
#include "problem/static_start.h"
#include "scene/targets.h"
#include "trajectory/step_control.h"
#include <array>
#include <fmt/format.h>

namespace signorini::problem {
using petsc::check;

namespace {

template <class Make>
auto timed(Timers& timers, const char* phase, Make&& make) {
  const auto timer = timers.time(phase);
  return make();
}

mesh::Mesh read_mesh(MPI_Comm comm, const scene::Scene& scene, const mesh::Meshing& meshing) {
  mesh::Mesh mesh(comm, scene.mesh, meshing);
  scene::require_dimension(scene, mesh.dim());
  // The groups must exist even if this run uses neither control nor objective.
  if (scene.control && scene.control->on)
    (void)mesh.group_dimension(*scene.control->on, "control.on");
  if (scene.objective && scene.objective->on)
    (void)mesh.group_dimension(*scene.objective->on, "objective.on");
  return mesh;
}

using Displacements = std::unique_ptr<const step::Displacements>;

/// Simulates the motion under a reference control and stores the states.
Displacements computed(const Problem& problem, const control::ControlSpace& controls,
                       const control::Control& reference, const trajectory::StateStoreFactory& storage,
                       const Console& console) {
  /// Motion under a control. Owns the control's force, with which checkpointed steps are recomputed.
  class Computed final : public step::Displacements {
  public:
    Computed(const Problem& problem, const control::ControlSpace& controls, const control::Control& u,
             const trajectory::StateStoreFactory& storage)
        : force_(controls, u), trajectory_(problem.stepper, problem.initial, storage) {}
    void run(const Problem& problem, const trajectory::StepObserver& watch) {
      trajectory_.run(problem.load(&force_), watch);
      if (trajectory_.steps() < problem.steps())
        throw Interrupted();
    }
    [[nodiscard]] Vec y(const step::TimeStep& step) const override { return trajectory_.y(step); }

  private:
    control::ControlForce force_;
    trajectory::Trajectory trajectory_;
  };
  auto motion = std::make_unique<Computed>(problem, controls, reference, storage);
  Progress progress(console, "desired state", static_cast<std::size_t>(problem.steps()));
  motion->run(problem, [&](const trajectory::Frame& frame) {
    progress.update(static_cast<std::size_t>(frame.step.k));
  });
  return motion;
}

/// A displacement at time t. Collective.
using Evaluate = std::function<void(double t, Vec y)>;

/// Motion that is evaluated at construction and kept in memory.
class StoredMotion final : public step::Displacements {
public:
  StoredMotion(const Problem& problem, const Evaluate& evaluate)
      : all_(petsc::zero_series(problem.initial.y(), static_cast<std::size_t>(problem.steps()) + 1)) {
    for (int k = 0; k <= problem.steps(); ++k)
      evaluate(problem.grid.time(k), all_[static_cast<std::size_t>(k)]);
  }
  [[nodiscard]] Vec y(const step::TimeStep& step) const override {
    return all_[static_cast<std::size_t>(step.k)];
  }

private:
  petsc::Series all_;
};

/// Motion that is evaluated on demand.
class Evaluated final : public step::Displacements {
public:
  Evaluated(const Problem& problem, Evaluate evaluate)
      : problem_(problem), evaluate_(std::move(evaluate)), y_(problem.space.vector()) {}
  [[nodiscard]] Vec y(const step::TimeStep& step) const override {
    if (std::exchange(last_, step.k) != step.k) {
      const auto timer = problem_.timers.time("desired state");
      evaluate_(step.end, y_);
    }
    return y_;
  }

private:
  const Problem& problem_;
  Evaluate evaluate_;
  petsc::Vector y_;
  mutable int last_ = -1; ///< step last evaluated: it is requested several times in a row
};

/// A motion that is constant in time: its displacement is evaluated once.
class Constant final : public step::Displacements {
public:
  Constant(const Problem& problem, const Evaluate& evaluate) : y_(problem.space.vector()) { evaluate(0, y_); }
  [[nodiscard]] Vec y(const step::TimeStep&) const override { return y_; }

private:
  petsc::Vector y_;
};

/// Sets the translation of an obstacle with mass in y to a field's value at its centre of mass.
void set_translation(const Problem& problem, const std::string& obstacle, const scene::Field& field, double t,
                     Vec y) {
  const contact::RigidMotion& motion =
      *problem.stepper.pairs()->rigid(scene::obstacle_number(problem.scene.contacts, obstacle));
  std::array<double, 3> value{};
  field.evaluate(motion.center().data(), t, value.data());
  motion.set_translation(value, y);
}

Displacements given(const Problem& problem, Evaluate evaluate, bool keep) {
  if (keep)
    return std::make_unique<StoredMotion>(problem, evaluate);
  return std::make_unique<Evaluated>(problem, std::move(evaluate));
}

Displacements desired_states(const Problem& problem, const control::ControlSpace& controls,
                             const std::optional<control::Control>& reference,
                             const trajectory::StateStoreFactory& storage, const Console& console) {
  const auto timer = problem.timers.time("desired state");
  return reference ? computed(problem, controls, *reference, storage, console)
                   : given_motion(problem, storage.in_memory());
}

/// Throws UserError if a control and, if `motion`, the states of a motion would exceed the machine's memory,
/// counted once for each rank. So many steps are hardly intended, and Linux would grant the memory until it
/// kills the program.
void require_memory(const Problem& problem, const control::ControlSpace& controls, bool motion) {
  const bool kept = motion && problem.scene.trajectory.storage == scene::Storage::memory;
  const double states =
                   kept ? static_cast<double>(motions(problem.scene)) * state_stores(problem).bytes() : 0,
               needed = controls.control_bytes() + states,
               room = machine_memory() * ranks(problem.space.comm());
  if (needed > room)
    throw UserError(fmt::format("time.step: found {:.10g} s, which gives {} steps. For these, a control{} "
                                "would need {:.3g} GB of memory, but this machine has {:.3g} GB; use longer "
                                "steps",
                                problem.scene.time.step, problem.steps(), kept ? " and a motion" : "",
                                needed / 1e9, room / 1e9));
}

control::Control first_guess(const control::ControlSpace& controls, const scene::Control& scene) {
  control::Control u = scene.stored
                           ? io::stored_control(controls, scene, scene.stored->folder, "control.initial.run")
                       : scene.initial ? controls.interpolate(*scene.initial, "control.initial")
                                       : controls.zero();
  controls.project(u);
  return u;
}

std::optional<control::Control> reference_control(const Problem& problem,
                                                  const control::ControlSpace& controls) {
  require_memory(problem, controls, true);
  if (const auto* desired = std::get_if<scene::DesiredControl>(&problem.scene.objective->desired))
    return controls.interpolate(desired->control, "objective.desired.control");
  return std::nullopt;
}

} // namespace

step::Stepper::Needs simulation_needs(const scene::Scene& scene) {
  const bool two = scene.objective && std::holds_alternative<scene::DesiredControl>(scene.objective->desired);
  return {.passes = two ? 2.0 : 1.0};
}

step::Stepper::Needs study_needs(const scene::Scene& scene) {
  constexpr double motion = 1, gradient = 3; // the desired motion's pass included
  return {.derivatives = scene.objective.has_value(), .passes = scene.objective ? gradient : motion};
}

step::Stepper::Needs check_needs(const scene::Scene& scene) {
  constexpr double few = 10;
  return {.derivatives = scene.objective.has_value(), .passes = few};
}

step::Stepper::Needs search_needs(const scene::Scene& scene) {
  constexpr int usual = 50;    // iterations for most of the possible decrease
  constexpr double sweeps = 2; // forward and adjoint
  return {.derivatives = true, .passes = sweeps * (1 + std::min(usual, scene.optimizer.max_iterations))};
}

step::Stepper::Needs fit_needs(const scene::Scene& scene) {
  return {.derivatives = true, .passes = 1 + static_cast<double>(scene.unknowns.size())};
}

SpaceDiscretisation::SpaceDiscretisation(MPI_Comm comm, const scene::Scene& scene, Timers& timers,
                                         const mesh::Meshing& meshing)
    : mesh(timed(timers, "mesh", [&] { return read_mesh(comm, scene, meshing); })),
      space(mesh, scene.mesh.degree,
            contact::virtual_nodes(scene.contacts, mesh.dim(), mesh.axisymmetric())) {}

Problem::Problem(std::shared_ptr<const SpaceDiscretisation> shared, const scene::Scene& s,
                 step::Stepper::Needs needs, Timers& t, trajectory::Stops stops, const Problem* like)
    : scene(s), timers(t), discretisation(std::move(shared)), mesh(discretisation->mesh),
      space(discretisation->space, contact::virtual_nodes(s.contacts, mesh.dim(), mesh.axisymmetric())),
      shared_operators(like ? like->shared_operators
                            : timed(t, "assembly",
                                    [&] {
                                      return std::make_shared<const fem::Operators>(fem::assemble_operators(
                                          space, s.materials, has_densities(s, needs), s.foundations));
                                    })),
      operators(*shared_operators),
      stepper(
          timed(t, "solver",
                [&] { return step::Stepper(space, operators, s, needs, like ? &like->stepper : nullptr); })),
      grid(stepper.step_lengths() ? step::TimeGrid(*stepper.step_lengths()) : step::TimeGrid(s.time)),
      initial(trajectory::initial_state(stepper, s)), needs(needs) {
  if (stops == trajectory::Stops::obeyed && stop_requested(space.comm()))
    throw Interrupted();
  if (step::SceneLoad::acts(s))
    scene_load.emplace(space, stepper.M(), s, stepper.end());
  if (s.initial.equilibrium)
    start_in_equilibrium(stepper, operators, s, scene_load ? &*scene_load : nullptr, initial.y());
  if (!s.output.probes.empty())
    probes.emplace(stepper, s);
}

long Problem::free_dofs() const {
  long clamped = static_cast<long>(stepper.clamped().dofs().size());
  MPI_Allreduce(MPI_IN_PLACE, &clamped, 1, MPI_LONG, MPI_SUM, space.comm());
  return static_cast<long>(space.dofs()) - clamped;
}

GivenControl::GivenControl(const Problem& problem) : problem_(problem) {
  if (!has_given_control(problem.scene))
    return;
  const scene::Control& control = *problem.scene.control;
  controls_.emplace(problem.space, problem.operators, problem.grid, control);
  if (controls_->stepwise() && !problem.grid.complete()) {
    if (control.stored)
      throw UserError(
          "control.initial: found the control of an earlier run in a scene with time.step = "
          "\"auto\", which needs intervals of fixed length; set control.step, or give expressions");
    force_ = std::make_unique<control::SampledForce>(*controls_, *control.initial, "control.initial", true);
    return;
  }
  require_memory(problem, *controls_, false);
  control_ = first_guess(*controls_, control);
  force_ = std::make_unique<control::ControlForce>(*controls_, *control_);
}

control::Control GivenControl::control(const control::ControlSpace& controls) const {
  if (!acts())
    return controls.zero();
  return control_ ? *control_ : first_guess(controls, *problem_.scene.control);
}

void choose_steps(Problem& problem, const step::ForceAtStep& load, const Console& console) {
  const auto timer = problem.timers.time("lengths of steps");
  trajectory::StepControl control(problem.stepper, problem.scene);
  const step::TimeGrid grid =
      trajectory::integrate_choosing(problem.stepper, problem.initial, load, control, {});
  if (!grid.complete())
    throw Interrupted();
  double shortest = grid.end(), longest = 0;
  for (int k = 1; k <= grid.steps(); ++k) {
    shortest = std::min(shortest, grid.length(k));
    longest = std::max(longest, grid.length(k));
  }
  console.line(fmt::format("{} steps of {:.3g} s to {:.3g} s, chosen in a preliminary motion with {} "
                           "repeated steps",
                           grid.steps(), shortest, longest, control.rejected()));
  problem.grid = grid;
}

void choose_steps(Problem& problem, const control::ControlSpace& from, const control::Control& u,
                  const Console& console) {
  const control::ControlSpace held(problem.space, problem.operators, from.grid(), *problem.scene.control);
  const control::Control here = control::Interpolation(from, held)(u);
  const control::ControlForce force(held, here, control::ForceSteps::others);
  choose_steps(problem, problem.load(&force), console);
}

void choose_steps(Problem& problem, const Console& console) {
  if (problem.grid.complete())
    return;
  const scene::Scene& scene = problem.scene;
  const auto* desired =
      scene.objective ? std::get_if<scene::DesiredControl>(&scene.objective->desired) : nullptr;
  if (!has_given_control(scene) && desired) {
    const control::ControlSpace controls(problem.space, problem.operators, problem.grid, *scene.control);
    const control::SampledForce reference(controls, desired->control, "objective.desired.control", false);
    choose_steps(problem, problem.load(&reference), console);
  } else {
    choose_steps(problem, GivenControl(problem).load(), console);
  }
}

Displacements given_motion(const Problem& problem, bool keep) {
  if (const auto* run = std::get_if<scene::DesiredRun>(&problem.scene.objective->desired)) {
    const auto stored =
        std::make_shared<io::StoredField>(problem.space, io::fields_file(run->folder, "state"),
                                          "displacement", "objective.desired.run", problem.stepper.end());
    return given(problem, [stored](double t, Vec y) { stored->at(t, y); }, keep);
  }
  const auto& desired = std::get<scene::DesiredDisplacement>(problem.scene.objective->desired);
  const auto field =
      std::make_shared<scene::Field>(desired.displacement, "objective.desired.displacement", true);
  const Evaluate evaluate = [&problem, field](double t, Vec y) {
    if (const std::optional<std::string>& obstacle = problem.scene.objective->obstacle)
      set_translation(problem, *obstacle, *field, t, y);
    else
      problem.space.interpolate(*field, t, y);
  };
  if (field->depends_on_time())
    return given(problem, evaluate, keep);
  return std::make_unique<Constant>(problem, evaluate);
}

std::optional<Warning> desired_run_spacing_warning(const Problem& problem) {
  const auto* run =
      problem.scene.objective ? std::get_if<scene::DesiredRun>(&problem.scene.objective->desired) : nullptr;
  if (!run)
    return std::nullopt;
  const step::TimeGrid& grid = problem.grid;
  std::vector<double> times;
  try {
    times = io::StoredField(problem.space, io::fields_file(run->folder, "state"), "displacement",
                            "objective.desired.run", grid.end())
                .times();
  } catch (const UserError&) { // the file is gone since it was read
    return std::nullopt;
  }
  double apart = 0, longest = 0;
  for (std::size_t i = 1; i < times.size(); ++i)
    apart = std::max(apart, times[i] - times[i - 1]);
  for (int k = 1; k <= problem.steps(); ++k)
    longest = std::max(longest, grid.length(k));
  constexpr double alike = 1.5;
  if (!(apart > alike * longest))
    return std::nullopt;
  return Warning{"desired motion between stored times",
                 fmt::format("the stored states of {} are up to {:.3g} s apart, but the steps here are "
                             "{:.3g} s; states are interpolated linearly. Repeat that run with output.every "
                             "= 1",
                             run->folder.string(), apart, longest),
                 apart / longest, alike};
}

trajectory::StateStoreFactory state_stores(const Problem& problem, std::size_t motions) {
  const bool computed = std::holds_alternative<scene::DesiredControl>(problem.scene.objective->desired);
  return {problem.stepper, problem.grid, problem.scene.trajectory,
          (computed ? 0.5 : 1) / static_cast<double>(motions), problem.timers};
}

step::ForceAtStep GivenControl::load() const { return problem_.load(force_.get()); }

namespace {

std::unique_ptr<control::ReducedProblem> reduced_problem(const ControlProblem& of, const Problem& problem) {
  const control::Model model{.stepper = &problem.stepper,
                             .initial = &problem.initial,
                             .storage = &of.storage,
                             .load = problem.scene_loads()};
  if (of.scenarios)
    return of.scenarios->reduced(model);
  return std::make_unique<control::ReducedProblem>(model, of.controls, of.objective, problem.timers);
}

} // namespace

ControlProblem::ControlProblem(const Problem& problem, const Console& console)
    : controls(problem.space, problem.operators, problem.grid, *problem.scene.control),
      reference(reference_control(problem, controls)), storage(state_stores(problem, motions(problem.scene))),
      desired_storage(state_stores(problem)),
      objective(controls, problem.operators, problem.grid,
                desired_states(problem, controls, reference, desired_storage, console), problem.scene),
      scenarios(problem.scene.scenarios.empty() ? nullptr
                                                : std::make_unique<Scenarios>(problem, controls, objective)),
      owned(reduced_problem(*this, problem)), reduced(*owned) {}

ControlProblem::~ControlProblem() = default;

control::Control ControlProblem::first_guess(const scene::Scene& scene) const {
  return problem::first_guess(controls, *scene.control);
}

} // namespace signorini::problem
