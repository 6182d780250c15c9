// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/run.h"
#include "accuracy/grading.h"
#include "accuracy/optimize_to_accuracy.h"
#include "app/info.h"
#include "app/scene_file.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/machine.h"
#include "base/signals.h"
#include "drivers/check/check.h"
#include "drivers/motion_writer.h"
#include "drivers/run_manifest.h"
#include "drivers/search.h"
#include "drivers/summary_lines.h"
#include "drivers/synthetic_data.h"
#include "io/manifest.h"
#include "io/output_folder.h"
#include "problem/run_objective.h"
#include "trajectory/step_control.h"
#include <chrono>
#include <cmath>
#include <fmt/format.h>

namespace signorini::app {
namespace {

MPI_Comm world() { return MPI_COMM_WORLD; }

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

/// `whole`: a motion that is interrupted is not written, which would take the place of a whole one.
int simulate_scene(const scene::Scene& scene, const std::filesystem::path& out, const Request& request,
                   const Console& console, const std::optional<io::Accuracy>& accuracy = {},
                   bool keep_mesh = false, bool whole = false) {
  io::OutputFolder folder(world(), out);
  scene::Scene told = scene;
  mesh::Meshing meshing;
  if (keep_mesh) {
    meshing.keep = folder.staged(kept_mesh);
    told.mesh.file = folder.path() / kept_mesh;
    told.mesh.size.reset(), told.mesh.scale = 1;
  }
  if (!request.replace)
    folder.require_no_search(out);
  if (request.measure)
    drivers::require_measurable(world(), scene, out, request.replace);
  Timers timers;
  problem::Problem problem(std::make_shared<const problem::Discretisation>(world(), scene, timers, meshing),
                           scene, problem::simulation_needs(scene), timers);
  console.line(drivers::headline(problem));

  const problem::GivenControl given(problem);
  const step::ForceAtStep load = given.load();
  std::optional<problem::RunObjective> objective;
  const std::string unknown = start_objective(problem, given, objective);
  std::optional<trajectory::StepControl> control;
  if (!problem.grid.equal())
    control.emplace(problem.stepper, scene);
  drivers::MotionWriter recorder(problem, folder, nullptr, given.acts(),
                                 control ? &control->errors() : nullptr);
  std::optional<drivers::SyntheticData> data;
  if (request.measure)
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
  if (steps == 0 || (whole && !complete)) // no result that could replace an earlier run's
    throw Interrupted();
  recorder.finish();
  folder.write("scene.toml", scene::echo(told, problem.space.dim()));
  io::Manifest m = drivers::manifest(problem, "simulate", complete ? "end of time" : "interrupted", steps);
  if (m.lengths)
    m.lengths->rejected = control->rejected();
  drivers::add_watched(m, recorder, scene.run, console);
  m.accuracy = accuracy;
  if (objective && complete) {
    m.objective = objective->value();
    drivers::add_warning(m, problem::desired_warning(problem), console);
  }
  m.files = folder.files();
  folder.write("run.json", io::to_json(m, told, timers));
  for (const std::string& line : drivers::summary_lines(m))
    console.line(line);
  if (m.objective)
    console.line(fmt::format("J = {:.6e} (tracking {:.3e}, terminal {:.3e}, control {:.3e})",
                             m.objective->total(), m.objective->tracking, m.objective->terminal,
                             m.objective->control_cost));
  if (!unknown.empty())
    console.line("J is not known: " + unknown);
  console.line(fmt::format("{}{}", complete ? "" : "interrupted after ",
                           drivers::cost_line(m, scene, timers, folder.bytes())));
  if (data && complete) // before the results are in place: they stand for data that are written
    for (const std::string& line : data->write(request.seed))
      console.line(line);
  drivers::finish(folder, console);
  return complete ? exit_status::done : exit_status::interrupted;
}

/// A folder that is gone with this object; its name is known on every rank. Collective.
class ScratchFolder {
public:
  explicit ScratchFolder(MPI_Comm comm) : comm_(comm) {
    std::string name;
    on_root(comm, [&] {
      name = (std::filesystem::temp_directory_path() / "signorini-XXXXXX").string();
      if (!mkdtemp(name.data()))
        throw WriteFailure(fmt::format("{}: the folder cannot be made", name));
    });
    path_ = broadcast(comm, name);
  }
  ~ScratchFolder() {
    std::error_code left;
    if (rank(comm_) == 0)
      std::filesystem::remove_all(path_, left);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

private:
  MPI_Comm comm_;
  std::filesystem::path path_;
};

/// simulate with --accuracy: searches a size and a step, writes the motion of each that is better than those
/// before, and says what came of it.
int simulate_to_accuracy(scene::Scene scene, const std::filesystem::path& out, Request request,
                         const Console& console) {
  const auto start = std::chrono::steady_clock::now();
  const double asked = *request.accuracy;
  if (request.study.budget)
    stop_after(*request.study.budget);
  accuracy::BestRun best;
  bool stopped = false, answered = false;
  std::optional<ScratchFolder> scratch;
  if (scene.mesh.automatic()) { // from now on at a scale of sizes that vary
    scene::Scene simulated = scene;
    simulated.objective.reset();
    const std::filesystem::path graded = scratch.emplace(world()).path() / "graded.geo";
    accuracy::write_graded(world(), simulated, graded, console);
    scene.mesh.file = graded;
    scene.mesh.size.reset();
  }
  const auto write = [&](const accuracy::BestRun& found) {
    const io::Accuracy accuracy{.quantity = request.study.quantities.front(),
                                .asked = asked,
                                .space = found.space,
                                .time = found.time,
                                .met = found.meets(asked),
                                .warning = found.warning};
    (void)simulate_scene(accuracy::on_rung(scene, found.rung), out, request, Console(false, false), accuracy,
                         scratch.has_value(), answered);
    request.replace = true; // from now on it is this run's own
    best = found;
    answered = true;
  };
  try {
    (void)accuracy::find_size_and_step(world(), scene, asked, request.study, console, write);
  } catch (const Interrupted&) {
    if (!answered)
      throw;
    stopped = true;
  }
  const bool late = time_is_up(world()), met = best.meets(asked);
  forget_deadline();
  double passed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  MPI_Bcast(&passed, 1, MPI_DOUBLE, 0, world());
  const std::string asked_for = fmt::format("{:g} of {} asked", asked, request.study.quantities.front()),
                    end = met                    ? std::string("met")
                          : stopped && !late     ? "not met, interrupted"
                          : late                 ? "not met, the budget is spent"
                          : best.warning.empty() ? "not met"
                                                 : "not verified, " + best.warning,
                    resolution = accuracy::words(best.rung, scene);
  if (best.seconds == 0) // the first of all
    console.line(fmt::format("{}, no error estimate yet: {}; {}, {:.2g} s in all", asked_for, end, resolution,
                             passed));
  else
    console.line(fmt::format(
        "{}, {:.2e} estimated (space {:.1e}, time {:.1e}): {}; {}, {:.2g} s in all, of which the run "
        "took {:.2g} s; {} would take about {:.2g} s",
        asked_for, best.error(), best.space, best.time, end, resolution, passed, best.seconds,
        best.error() > asked ? "what is asked" : "half the error", best.further));
  console.line(fmt::format("results in {}", out.string()));
  return met ? exit_status::done : stopped && !late ? exit_status::interrupted : exit_status::check_failed;
}

int check(const scene::Scene& scene, const Console& console) {
  Timers timers;
  problem::Problem problem(world(), scene, problem::check_needs(scene), timers);
  console.line(drivers::headline(problem));
  return drivers::check_scene(problem, console) ? exit_status::done : exit_status::check_failed;
}

/// Where a run's results go if the user names no folder: those of an echo back to where it is.
std::filesystem::path usual_folder(const std::string& verb, const std::string& name,
                                   const std::filesystem::path& home) {
  if (verb == "study")
    return (home.empty() ? "results" : home.parent_path()) / (name + "-study");
  return home.empty() ? std::filesystem::path("results") / name : home;
}

/// A run replaces scene.toml in its folder by the echo of its scene. Where that file is itself the scene to
/// be run, it must be an unchanged echo. Throws UserError.
void require_not_the_users(const scene::Scene& scene, const std::string& text,
                           const std::filesystem::path& out) {
  const std::filesystem::path echo = out / "scene.toml";
  std::error_code none;
  if (!std::filesystem::equivalent(scene.file, echo, none))
    return;
  const scene::Scene written = scene::parse(text, scene.file, {});
  for (int dim : {2, 3})
    if (scene::echo(written, dim) == text)
      return;
  throw UserError(
      fmt::format("--out: found the scene itself, {}, which the run would replace, allowed is another folder",
                  echo.string()));
}

/// Throws UserError if the run would replace the control that it starts from.
void require_not_the_guess(const scene::Scene& scene, const std::filesystem::path& out) {
  std::error_code none;
  if (scene.control && scene.control->stored &&
      std::filesystem::equivalent(scene.control->stored->folder, out, none))
    throw UserError(
        fmt::format("--out: found the folder of control.initial.run, {}, whose control this run would "
                    "replace, allowed is another",
                    out.string()));
}

/// Sizes are chosen for an ordered accuracy alone. Throws UserError.
void require_size(const scene::Scene& scene, const Request& request) {
  if (scene.mesh.automatic() && !scene.unknowns.empty())
    throw UserError(
        "mesh.size: found \"auto\" with tables [[unknown]], allowed without, with --accuracy; else "
        "a size in m, such as --set mesh.size=0.1");
  if (scene.mesh.automatic() && !request.accuracy)
    throw UserError(fmt::format("mesh.size: found \"auto\" with {}, allowed with --accuracy; else a "
                                "size in m, such as --set mesh.size=0.1",
                                request.verb));
}

/// Nothing tells the error of a fit's misfit. Throws UserError.
void require_no_order_of_a_fit(const scene::Scene& scene, const Request& request) {
  if (request.verb == "optimize" && !scene.unknowns.empty() && (request.accuracy || request.study.budget))
    throw UserError(fmt::format("{}: found with tables [[unknown]], allowed without; "
                                "optimizer.tolerance and optimizer.max_iterations end a fit",
                                request.accuracy ? "--accuracy" : "--budget"));
}

} // namespace

int run(const Request& request, const Console& console) {
  return run(request, read_scene(world(), request.scene, request.overrides), console);
}

int run(const Request& request, const SceneFile& file, const Console& console) {
  use_threads(world(), request.threads);
  const auto& [scene, text, home] = file;
  drivers::print_table_warnings(drivers::series_warnings(world(), scene), console);
  require_no_order_of_a_fit(scene, request);
  require_size(scene, request);
  const std::filesystem::path out =
      request.out.empty() ? usual_folder(request.verb, scene.name, home) : request.out;
  if (request.verb == "simulate" || request.verb == "optimize")
    on_root(world(), [&] {
      require_not_the_users(scene, text, out);
      require_not_the_guess(scene, out);
    });
  if (request.verb == "simulate" && request.accuracy)
    return simulate_to_accuracy(scene, out, request, console);
  if (request.verb == "simulate")
    return simulate_scene(scene, out, request, console);
  if (request.verb == "optimize" && request.accuracy)
    return accuracy::optimize_to_accuracy(world(), scene, out, {*request.accuracy, request.study.budget},
                                          console);
  if (request.verb == "optimize")
    return drivers::search_scene(world(), scene, out, request.resume, console);
  if (request.verb == "check")
    return check(scene, console);
  if (request.verb == "study")
    return request.suggest ? accuracy::suggest(world(), scene, *request.suggest, request.study, console)
                           : accuracy::run_study(world(), scene, out, request.study, console);
  Timers timers;
  problem::Problem problem(world(), scene, problem::study_needs(scene), timers);
  print_info(problem, request.timed_steps, console);
  return exit_status::done;
}

} // namespace signorini::app
