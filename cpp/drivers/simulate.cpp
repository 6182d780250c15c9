// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/simulate.h"
#include "base/error.h"
#include "drivers/motion_writer.h"
#include "drivers/run_manifest.h"
#include "drivers/summary_lines.h"
#include "drivers/synthetic_data.h"
#include "problem/run_objective.h"
#include "trajectory/drop.h"
#include "trajectory/step_control.h"
#include <cmath>
#include <fmt/format.h>

namespace signorini::drivers {
namespace {

/// Number of steps between stored frames of a bounce whose length is unknown: eight frames while a wave
/// crosses the body.
int steps_between_frames(const problem::Problem& problem) {
  constexpr double frames = 8;
  const double crossing = diagnostics::body_figures(problem.stepper, problem.scene).crossing;
  return std::max(1, static_cast<int>(crossing / frames / problem.scene.time.step));
}

Warning not_bounced(double end) {
  return {
      "bounce not over",
      fmt::format("the bounce was not over at {:.4g} s, when a perfectly elastic one would have come down "
                  "again. For a longer motion give time.end in s",
                  end),
      end, end};
}

/// Simulation of a scene under its given control, with the recorders of the motion.
class Simulation {
public:
  /// Opens the recorders. `measure`: whether to simulate the scene's measurements. Throws UserError.
  /// Collective.
  Simulation(problem::Problem& problem, const io::OutputFolder& folder, bool measure)
      : problem_(problem), given_(problem), load_(given_.load()) {
    start_objective();
    if (!problem.grid.equal())
      control_.emplace(problem.stepper, problem.scene);
    recorder_.emplace(problem, folder, nullptr, given_.acts(), control_ ? &control_->errors() : nullptr);
    if (measure)
      data_.emplace(problem.stepper, problem.grid, problem.scene);
  }

  /// Computes all time steps. Throws UserError, SolverFailure, WriteFailure. Collective.
  void run(const Console& console) {
    constexpr int per_mille = 1000;
    const auto timer = problem_.timers.time("forward");
    const bool equal = problem_.grid.equal();
    Progress progress(console, equal ? "steps" : "per mille of the time",
                      static_cast<std::size_t>(equal ? problem_.grid.steps() : per_mille));
    const auto watch = [&](const trajectory::Frame& frame) {
      (*recorder_)(frame);
      if (objective_)
        objective_->observe(frame);
      if (data_)
        data_->observe(frame);
      if (problem_.scene.time.until_bounce)
        bounced_ = over(frame);
      progress.update(static_cast<std::size_t>(
          equal ? frame.step.k : std::floor(per_mille * frame.step.end / problem_.stepper.end())));
    };
    if (control_) {
      problem_.grid =
          trajectory::integrate_choosing(problem_.stepper, problem_.initial, load_, *control_, watch);
      steps_ = problem_.steps();
    } else {
      steps_ = trajectory::integrate(problem_.stepper, problem_.grid, problem_.initial, load_, watch,
                                     trajectory::Stops::obeyed, [this] { return bounced(); });
      if (bounced())
        problem_.grid = problem_.grid.first(steps_);
    }
  }

  /// Whether the motion ended with its bounce.
  [[nodiscard]] bool bounced() const { return bounced_; }
  [[nodiscard]] int steps() const { return steps_; }
  [[nodiscard]] bool complete() const { return problem_.grid.complete() && steps_ == problem_.steps(); }
  [[nodiscard]] MotionWriter& recorder() { return *recorder_; }
  [[nodiscard]] const std::optional<SyntheticData>& data() const { return data_; }
  /// Reason why J cannot be computed although the scene has an objective; else empty.
  [[nodiscard]] const std::string& unknown() const { return unknown_; }

  /// Collects the entries of run.json and prints the warnings of the motion. Collective.
  [[nodiscard]] io::Manifest described(const Console& console) {
    io::Manifest m = manifest(problem_, "simulate", complete() ? "end of time" : "interrupted", steps_);
    if (m.lengths)
      m.lengths->rejected = control_->rejected();
    add_watched(m, *recorder_, problem_.scene.run, console);
    if (problem_.scene.time.until_bounce && complete() && !bounced())
      add_warning(m, not_bounced(problem_.stepper.end()), console);
    if (objective_ && complete()) {
      m.objective = objective_->value();
      add_warning(m, problem::desired_run_spacing_warning(problem_), console);
    }
    return m;
  }

private:
  /// Whether the bounce is over and its rotation does not bring the body down again. Collective.
  [[nodiscard]] bool over(const trajectory::Frame& frame) {
    if (!recorder_->bounced())
      return false;
    const step::Stepper& stepper = problem_.stepper;
    if (!rigid_)
      rigid_.emplace(problem_.space, stepper.clamped(), stepper.M());
    return !trajectory::touches_again(stepper, *rigid_, frame, stepper.end());
  }

  /// Sets up the objective, if the scene has one. The simulation continues if the run of the desired motion
  /// is missing or invalid.
  void start_objective() {
    if (!problem_.scene.objective)
      return;
    try {
      objective_.emplace(problem_, given_);
    } catch (const UserError& error) {
      if (!std::holds_alternative<scene::DesiredRun>(problem_.scene.objective->desired))
        throw;
      unknown_ = error.what();
    }
  }

  problem::Problem& problem_;
  problem::GivenControl given_;
  step::ForceAtStep load_;
  std::optional<problem::RunObjective> objective_;
  std::string unknown_;
  std::optional<trajectory::StepControl> control_;
  std::optional<MotionWriter> recorder_;
  std::optional<SyntheticData> data_;
  std::optional<fem::RigidMotions> rigid_; ///< of the body, once its bounce may be over
  bool bounced_ = false;
  int steps_ = 0;
};

} // namespace

int simulate_scene(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
                   const SimulateOptions& options, const Console& console) {
  io::OutputFolder folder(comm, out);
  scene::Scene written = scene;
  mesh::Meshing meshing;
  if (options.keep_mesh)
    keep_mesh(folder, meshing, written);
  if (!options.replace)
    folder.require_no_search(out);
  if (options.measure)
    require_measurable(comm, scene, out, options.replace);
  Timers timers;
  scene::Scene now = scene; // with time.end = "auto" the motion sets its end
  problem::Problem problem(std::make_shared<const problem::SpaceDiscretisation>(comm, scene, timers, meshing),
                           now, problem::simulation_needs(scene), timers);
  const bool chosen_frames = scene.time.until_bounce && scene.output.every == 0;
  if (chosen_frames)
    now.output.every = steps_between_frames(problem);
  console.line(headline(problem));
  if (!scene.scenarios.empty())
    console.line("note: this is the motion of the scene itself; only check and optimize use its scenarios");

  Simulation simulation(problem, folder, options.measure);
  if (chosen_frames)
    simulation.recorder().thin_out();
  simulation.run(console);
  now.output.every = simulation.recorder().every();
  const bool complete = simulation.complete();
  if (simulation.steps() == 0 ||
      (options.complete_only && !complete)) // no result that could replace an earlier one
    throw Interrupted();
  simulation.recorder().finish();
  if (scene.time.until_bounce) {
    now.time.steps = simulation.steps();
    now.time.end = now.time.steps * now.time.step;
    written.time = now.time;
    written.output.every = now.output.every;
  }
  folder.write("scene.toml", scene::echo(written, problem.space.dim()));
  io::Manifest m = simulation.described(console);
  m.accuracy = options.accuracy;
  m.files = folder.files();
  folder.write("run.json", io::to_json(m, written, timers));
  for (const std::string& line : summary_lines(m))
    console.line(line);
  if (m.objective)
    console.line(fmt::format("J = {:.6e} (tracking {:.3e}, terminal {:.3e}, control {:.3e})",
                             m.objective->total(), m.objective->tracking, m.objective->terminal,
                             m.objective->control_cost));
  if (!simulation.unknown().empty())
    console.line("J could not be evaluated: " + simulation.unknown());
  console.line(
      fmt::format("{}{}", complete ? "" : "interrupted after ", cost_line(m, now, timers, folder.bytes())));
  if (simulation.data() && complete) // before the results, whose presence implies that the data are written
    for (const std::string& line : simulation.data()->write(options.seed))
      console.line(line);
  finish(folder, console);
  return complete ? exit_status::done : exit_status::interrupted;
}

} // namespace signorini::drivers
