// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/run.h"
#include "accuracy/optimize_to_accuracy.h"
#include "accuracy/simulate_to_accuracy.h"
#include "app/info.h"
#include "app/mesh_info.h"
#include "app/scene_file.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/machine.h"
#include "drivers/check/check.h"
#include "drivers/run_manifest.h"
#include "drivers/search.h"
#include <fmt/format.h>

namespace signorini::app {
namespace {

MPI_Comm world() { return MPI_COMM_WORLD; }

drivers::SimulateOptions simulate_options(const Request& request) {
  return {.replace = request.replace, .measure = request.measure, .seed = request.seed};
}

int check(const scene::Scene& scene, const Console& console) {
  Timers timers;
  problem::Problem problem(world(), scene, problem::check_needs(scene), timers);
  console.line(drivers::headline(problem));
  return drivers::check_scene(problem, console) ? exit_status::done : exit_status::check_failed;
}

/// Default output folder of a run; if the scene is the echo of an earlier run, the folder of that run.
std::filesystem::path usual_folder(const std::string& verb, const std::string& name,
                                   const std::filesystem::path& run_folder) {
  if (verb == "study" || verb == "batch")
    return (run_folder.empty() ? "results" : run_folder.parent_path()) / (name + "-" + verb);
  return run_folder.empty() ? std::filesystem::path("results") / name : run_folder;
}

/// Throws UserError if a run would replace the user's scene file by the echo that it writes to scene.toml in
/// its output folder. If that file is the scene to be run, it must be an unchanged echo.
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
  throw UserError(fmt::format("--out: the run would replace its own scene file, {}; choose another folder",
                              echo.string()));
}

/// Throws UserError if a run would replace the stored control from which it starts.
void require_not_the_guess(const scene::Scene& scene, const std::filesystem::path& out) {
  std::error_code none;
  if (scene.control && scene.control->stored &&
      std::filesystem::equivalent(scene.control->stored->folder, out, none))
    throw UserError(fmt::format("--out: {} is the folder of control.initial.run, whose control this run "
                                "would replace; choose another folder",
                                out.string()));
}

/// Throws UserError unless mesh.size = "auto" is used with --accuracy and without unknowns.
void require_size(const scene::Scene& scene, const Request& request) {
  if (scene.mesh.automatic() && !scene.unknowns.empty())
    throw UserError("mesh.size: \"auto\" cannot be combined with [[unknown]]; give a size in m, such as "
                    "--set mesh.size=0.1");
  if (scene.mesh.automatic() && !request.accuracy)
    throw UserError(fmt::format(
        "mesh.size: {} accepts \"auto\" only with --accuracy; give a size in m, such as --set mesh.size=0.1",
        request.verb));
}

/// Throws UserError if a motion whose end is unknown is not to be simulated once.
void require_end(const scene::Scene& scene, const Request& request) {
  if (scene.time.until_bounce && ((request.verb != "simulate" && request.verb != "info") || request.accuracy))
    throw UserError(
        fmt::format("time.end: found \"auto\", which {} does not accept; give the end in s, such as "
                    "that in scene.toml of a simulation",
                    request.accuracy ? "--accuracy" : request.verb));
}

/// Throws UserError if --accuracy or --budget is used for a fit, since misfits have no error estimate.
void require_no_order_of_a_fit(const scene::Scene& scene, const Request& request) {
  if (request.verb == "optimize" && !scene.unknowns.empty() && (request.accuracy || request.study.budget))
    throw UserError(fmt::format("{}: has no effect on a fit, which has tables [[unknown]]; set "
                                "optimizer.tolerance or optimizer.max_iterations",
                                request.accuracy ? "--accuracy" : "--budget"));
}

} // namespace

int run(const Request& request, const Console& console) {
  if (request.verb == "info" && is_mesh(request.scene)) {
    if (request.timed_steps > 0)
      throw UserError("--time: has no effect on a mesh; use it with a scene");
    print_mesh_info(world(), request.scene, request.overrides, console);
    return exit_status::done;
  }
  return run(request, read_scene(world(), request.scene, request.overrides), console);
}

int run(const Request& request, const SceneFile& file, const Console& console) {
  use_threads(world(), request.threads);
  const auto& [scene, text, run_folder] = file;
  drivers::print_table_warnings(drivers::series_warnings(world(), scene), console);
  require_no_order_of_a_fit(scene, request);
  require_size(scene, request);
  require_end(scene, request);
  const std::filesystem::path out =
      request.out.empty() ? usual_folder(request.verb, scene.name, run_folder) : request.out;
  if (request.verb == "simulate" || request.verb == "optimize")
    on_root(world(), [&] {
      require_not_the_users(scene, text, out);
      require_not_the_guess(scene, out);
    });
  if (request.verb == "simulate" && request.accuracy)
    return accuracy::simulate_to_accuracy(world(), scene, out,
                                          {*request.accuracy, request.study.budget, request.study.quantities},
                                          simulate_options(request), console);
  if (request.verb == "simulate")
    return drivers::simulate_scene(world(), scene, out, simulate_options(request), console);
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
  if (request.verb == "batch") {
    batch::Options options = request.batch;
    options.resume = request.resume;
    options.quantities = request.study.quantities;
    const auto read = [&](std::vector<std::string> changes) {
      changes.insert(changes.begin(), request.overrides.begin(), request.overrides.end());
      return parse_scene(world(), file.text, request.scene, changes);
    };
    return batch::run_batch(world(), scene, read, out, options, console);
  }
  Timers timers;
  problem::Problem problem(world(), scene, problem::study_needs(scene), timers);
  print_info(problem, request.timed_steps, console);
  return exit_status::done;
}

} // namespace signorini::app
