// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/simulate.h"
#include "base/error.h"
#include "drivers/motion_writer.h"
#include "drivers/run_manifest.h"
#include "drivers/summary_lines.h"
#include "drivers/synthetic_data.h"
#include "problem/run_objective.h"
#include "trajectory/step_control.h"
#include <cmath>
#include <fmt/format.h>

namespace signorini::drivers {
namespace {

constexpr char kept_mesh[] = "mesh.msh";

/// Prepares J of a run. A desired run that is missing or another's is no reason not to simulate: returns why
/// J is not known then. Collective. Throws UserError.
std::string start_objective(const problem::Problem& problem, const problem::GivenControl& given,
                            std::optional<problem::RunObjective>& objective) {
  if (!problem.scene.objective)
    return {};
  try {
    objective.emplace(problem, given);
  } catch (const UserError& error) {
    if (!std::holds_alternative<scene::DesiredRun>(problem.scene.objective->desired))
      throw;
    return error.what();
  }
  return {};
}

} // namespace

int simulate_scene(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
                   const SimulateOptions& options, const Console& console) {
  io::OutputFolder folder(comm, out);
  scene::Scene written = scene;
  mesh::Meshing meshing;
  if (options.keep_mesh) {
    meshing.keep = folder.staged(kept_mesh);
    written.mesh.file = folder.path() / kept_mesh;
    written.mesh.size.reset(), written.mesh.scale = 1;
  }
  if (!options.replace)
    folder.require_no_search(out);
  if (options.measure)
    require_measurable(comm, scene, out, options.replace);
  Timers timers;
  problem::Problem problem(std::make_shared<const problem::Discretisation>(comm, scene, timers, meshing),
                           scene, problem::simulation_needs(scene), timers);
  console.line(headline(problem));

  const problem::GivenControl given(problem);
  const step::ForceAtStep load = given.load();
  std::optional<problem::RunObjective> objective;
  const std::string unknown = start_objective(problem, given, objective);
  std::optional<trajectory::StepControl> control;
  if (!problem.grid.equal())
    control.emplace(problem.stepper, scene);
  MotionWriter recorder(problem, folder, nullptr, given.acts(), control ? &control->errors() : nullptr);
  std::optional<SyntheticData> data;
  if (options.measure)
    data.emplace(problem.stepper, problem.grid, scene);
  constexpr int per_mille = 1000;
  int steps = 0;
  {
    const auto timer = timers.time("forward");
    Progress progress(console, problem.grid.equal() ? "steps" : "per mille of the time",
                      static_cast<std::size_t>(problem.grid.equal() ? problem.grid.steps() : per_mille));
    const auto watch = [&](const trajectory::Frame& frame) {
      recorder(frame);
      if (objective)
        objective->observe(frame);
      if (data)
        data->observe(frame);
      progress.update(static_cast<std::size_t>(
          problem.grid.equal() ? frame.step.k
                               : std::floor(per_mille * frame.step.end / problem.stepper.end())));
    };
    if (control) {
      problem.grid = trajectory::integrate_choosing(problem.stepper, problem.initial, load, *control, watch);
      steps = problem.steps();
    } else {
      steps = trajectory::integrate(problem.stepper, problem.grid, problem.initial, load, watch);
    }
  }
  const bool complete = problem.grid.complete() && steps == problem.steps();
  if (steps == 0 || (options.whole && !complete)) // no result that could replace an earlier run's
    throw Interrupted();
  recorder.finish();
  folder.write("scene.toml", scene::echo(written, problem.space.dim()));
  io::Manifest m = manifest(problem, "simulate", complete ? "end of time" : "interrupted", steps);
  if (m.lengths)
    m.lengths->rejected = control->rejected();
  add_watched(m, recorder, scene.run, console);
  m.accuracy = options.accuracy;
  if (objective && complete) {
    m.objective = objective->value();
    add_warning(m, problem::desired_warning(problem), console);
  }
  m.files = folder.files();
  folder.write("run.json", io::to_json(m, written, timers));
  for (const std::string& line : summary_lines(m))
    console.line(line);
  if (m.objective)
    console.line(fmt::format("J = {:.6e} (tracking {:.3e}, terminal {:.3e}, control {:.3e})",
                             m.objective->total(), m.objective->tracking, m.objective->terminal,
                             m.objective->control_cost));
  if (!unknown.empty())
    console.line("J is not known: " + unknown);
  console.line(
      fmt::format("{}{}", complete ? "" : "interrupted after ", cost_line(m, scene, timers, folder.bytes())));
  if (data && complete) // before the results are in place: they stand for data that are written
    for (const std::string& line : data->write(options.seed))
      console.line(line);
  finish(folder, console);
  return complete ? exit_status::done : exit_status::interrupted;
}

} // namespace signorini::drivers
