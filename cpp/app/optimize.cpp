// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/optimize.h"
#include "app/coarse_start.h"
#include "app/control_files.h"
#include "app/optimizer_log.h"
#include "app/run_manifest.h"
#include "base/collective.h"
#include "base/counters.h"
#include "base/error.h"
#include "forward/chatter.h"
#include "optimize/lbfgs.h"
#include "optimize/newton_cg.h"
#include "optimize/projected_gradient.h"
#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>

namespace signorini {
namespace {

/// steps.csv, contact.csv, state.xdmf.
void write_motion(const Problem& problem, const control::ReducedProblem& reduced, MotionWriter& recorder) {
  const auto timer = problem.timers.time("replay");
  forward::integrate(problem.stepper, problem.grid, problem.initial, reduced.load(), std::ref(recorder),
                     forward::Stops::ignored);
  recorder.finish();
}

/// How the states of motions were stored, and its cost, in words.
std::string storage_line(const Problem& problem, const ControlProblem& control_problem) {
  const auto seconds = [&](const char* phase) {
    const auto found = problem.timers.entries().find(phase);
    return found == problem.timers.entries().end() ? 0.0 : found->second.seconds;
  };
  const scene::Storage kept = problem.scene.trajectory.storage;
  const double bytes = control_problem.storage.bytes();
  const std::string room = fmt::format("{:.3g} MB", bytes * 1e-6);
  if (kept == scene::Storage::disk)
    return fmt::format("states on disk, {} a motion: written in {:.1f} s, read in {:.1f} s", room,
                       seconds("states written"), seconds("states read"));
  if (kept == scene::Storage::checkpoints)
    return fmt::format("states in checkpoints of {:.3g} MB: {} steps made again in {:.1f} s",
                       bytes * 1e-6 * (control_problem.reference ? 2 : 1), count("recomputed steps"),
                       seconds("states recomputed"));
  return fmt::format("states in memory, {} a motion", room);
}

/// How to go on with a search that stopped before its end, in words.
std::string going_on(optimize::Stop stop, const scene::Optimizer& scene) {
  if (scene.checkpoint == 0)
    return "";
  return stop == optimize::Stop::interrupted ? "; the same command with --resume goes on from here"
         : stop == optimize::Stop::iteration_limit
             ? "; the same command with --resume and a larger optimizer.max_iterations goes on from here"
             : "";
}

static_assert(optimize::TwiceDifferentiable<control::ReducedProblem>);
using Result = optimize::Result<control::Variables>;

/// Searches by a method, from where the checkpoint, coarse meshes or the first guess let it.
template <template <optimize::TwiceDifferentiable> class Method>
Result search(const Problem& problem, ControlProblem& control_problem, OptimizerLog& record,
              const Console& console, std::vector<io::CoarseLevel>& levels) {
  const optimize::Options options = search_options(control_problem.controls, problem.scene.optimizer);
  SearchStart<Method> start = record.resumes()
                                  ? SearchStart<Method>{control_problem.controls.zero()}
                                  : search_start<Method>(problem, control_problem, options, console, levels);
  return optimize::minimize<Method>(control_problem.reduced, std::move(start.guess), options, record, record,
                                    std::move(start.inherited));
}

Result minimise(const Problem& problem, ControlProblem& control_problem, OptimizerLog& record,
                const Console& console, std::vector<io::CoarseLevel>& levels) {
  using namespace optimize;
  switch (problem.scene.optimizer.method) {
  case scene::OptimizerMethod::lbfgs:
    return search<Lbfgs>(problem, control_problem, record, console, levels);
  case scene::OptimizerMethod::newton_cg:
    return search<NewtonCg>(problem, control_problem, record, console, levels);
  case scene::OptimizerMethod::projected_gradient:
  case scene::OptimizerMethod::gauss_newton: // of fits alone
    break;
  }
  return search<ProjectedGradient>(problem, control_problem, record, console, levels);
}

/// Describes the kink at which a search ended on the console.
void show(const io::Kink& kink, double first_norm, const Console& console) {
  std::string text = fmt::format(
      "no direction lowers J: {} gradients within {:.1e} of the control have a combination of length "
      "{:.2e}, {:.1e} of the first gradient's; ",
      kink.gradients, kink.radius, kink.length, kink.length / first_norm);
  text +=
      kink.weak.empty()
          ? std::string(
                "the same candidates are closed at all of them: J changes its piece nearer to the control, "
                "as where contact chatters")
          : fmt::format("contact is weak at {} candidates and steps:", kink.weak.size());
  console.line(text);
  constexpr std::size_t most_lines = 8;
  for (std::size_t i = 0; i < std::min(most_lines, kink.weak.size()); ++i)
    console.line(fmt::format("  step {} (t = {:.6g} s), node at ({:.6g}) m", kink.weak[i].step,
                             kink.weak[i].time, fmt::join(kink.weak[i].x, ", ")));
  if (kink.weak.size() > most_lines)
    console.line(fmt::format("  and {} more: run.json has them all", kink.weak.size() - most_lines));
}

/// Warns if a search ended without a minimum where candidates open and close from step to step, which breaks
/// J into many small pieces.
void add_chatter(io::Manifest& manifest, const control::ReducedProblem& reduced, const Console& console) {
  const forward::Alternations found = forward::alternations(reduced.trajectory().contact());
  const std::string other = forward::calmer_contact(reduced.stepper());
  if (found.alternating == 0)
    return;
  manifest.warnings.push_back(
      {"search among chattering contact",
       fmt::format(
           "the search found no further decrease where contact chatters: candidates open or close for "
           "a single step {} times while {} are closed over all steps; {}",
           found.alternating, found.closed, other),
       static_cast<double>(found.alternating), 0});
  console.line("warning: " + manifest.warnings.back().message);
}

/// A search that goes on does so with the solver that it had: its estimated times would differ.
forward::Stepper::Needs needs(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
                              bool resume) {
  forward::Stepper::Needs needs = search_needs(scene);
  const std::string before =
      resume ? io::checkpoint_text(comm, out / resume::checkpoint, OptimizerLog::solver) : "";
  needs.iterative =
      scene.solver.linear == scene::LinearMethod::automatic && before == OptimizerLog::iterative;
  if (!before.empty() && !needs.iterative)
    needs.passes = 0;
  return needs;
}

/// The steps that a checkpoint has. Throws UserError if they are not those of a motion.
forward::TimeGrid restored_steps(const forward::Ladder* ladder, const std::vector<double>& levels) {
  const std::optional<forward::TimeGrid> grid =
      ladder ? forward::TimeGrid::of_levels(*ladder, levels) : std::nullopt;
  if (!grid)
    throw UserError(
        "--resume: found a checkpoint with other lengths of steps, allowed is that of this scene");
  return *grid;
}

} // namespace

void require_control_problem(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out) {
  if (!scene.objective)
    throw UserError(
        fmt::format("{}: optimize needs the tables [control] and [objective], and the scene has {}",
                    scene.file.string(), scene.control ? "no objective" : "neither"));
  if (const auto* run = std::get_if<scene::DesiredRun>(&scene.objective->desired))
    on_root(comm, [&] {
      std::error_code missing;
      if (std::filesystem::equivalent(out, run->folder, missing))
        throw UserError(
            fmt::format("--out: found the folder of objective.desired.run, {}, whose files this run "
                        "would replace, allowed is another",
                        run->folder.string()));
    });
}

optimize::Options search_options(const control::ControlSpace& controls, const scene::Optimizer& scene) {
  constexpr double usual_bytes = 1e8, usual_controls = 128, least_controls = 16;
  const double each = controls.compact_bytes(), usual = std::max(usual_bytes, usual_controls * each),
               memory = scene.memory > 0 ? scene.memory : usual;
  if (memory < least_controls * each)
    throw UserError(
        fmt::format("optimizer.memory: found {:.10g} bytes, allowed is the room of {} controls in "
                    "single precision at least, here {:.10g} bytes",
                    memory, least_controls, least_controls * each));
  optimize::Options options{.max_iterations = scene.max_iterations,
                            .tolerance = scene.tolerance,
                            .vectors = static_cast<std::size_t>(memory / each)};
  options.bundle.dependent = 10 * std::numeric_limits<float>::epsilon(); // of vectors in single precision
  return options;
}

void write_optimum(io::OutputFolder& folder, const Problem& problem, const scene::Scene& scene,
                   ControlProblem& control_problem, OptimizerLog& record, FoundOptimum found,
                   const Console& console) {
  control::ReducedProblem& reduced = control_problem.reduced;
  const std::vector<io::HistoryRow>& rows = record.rows();
  if (scene.output.table(scene::StoredTable::history))
    folder.write("history.csv", io::history_table(rows));
  folder.write("scene.toml", scene::echo(scene, problem.space.dim()));
  MotionWriter recorder(problem, folder, &reduced.objective(), true);
  write_motion(problem, reduced, recorder);
  write_control(
      folder, problem, reduced.controls(), reduced.control(),
      [&](const auto& store) { reduced.adjoint_states(store); }, recorder.stored());
  const double first_norm = found.first_norm;
  console.line("stopped: " + optimize::name(found.stop) + going_on(found.stop, scene.optimizer));
  io::Manifest m = manifest(problem, "optimize", optimize::name(found.stop), reduced.trajectory().steps());
  add_watched(m, recorder, scene.run, console);
  add_warning(m, desired_warning(problem), console);
  if (found.stop == optimize::Stop::no_decrease)
    add_chatter(m, reduced, console);
  m.objective = reduced.value();
  m.iterations = rows.back().iteration;
  m.forward_sweeps = reduced.sweeps().forward;
  m.adjoint_sweeps = reduced.sweeps().adjoint;
  m.accuracy = found.accuracy;
  m.coarse_levels = std::move(found.levels);
  if (found.stop == optimize::Stop::kink) {
    m.kink = record.kink().value();
    show(*m.kink, first_norm, console);
  }
  m.files = folder.files();
  folder.write("run.json", io::to_json(m, scene, problem.timers));
  console.line(fmt::format(
      "J {:.6e} -> {:.6e} (tracking {:.3e}, terminal {:.3e}, control {:.3e}), |g| "
      "{:.2e} -> {:.2e} (tolerance {:.2e})\n{} iterations, {} forward and {} adjoint sweeps in {:.1f} s",
      rows.front().objective, m.objective->total(), m.objective->tracking, m.objective->terminal,
      m.objective->control_cost, first_norm, rows.back().gradient_norm,
      scene.optimizer.tolerance * first_norm, rows.back().iteration, *m.forward_sweeps, *m.adjoint_sweeps,
      rows.back().seconds));
  console.line(storage_line(problem, control_problem));
  finish(folder, console);
}

int optimize_scene(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out, bool resume,
                   const Console& console) {
  require_control_problem(comm, scene, out);
  io::OutputFolder folder(comm, out, resume ? resume::checkpoint : "");
  Timers timers;
  Problem problem(comm, scene, needs(comm, scene, out, resume), timers);
  console.line(headline(problem));
  if (const std::vector<double> levels =
          resume ? io::checkpoint_numbers(comm, out / resume::checkpoint, OptimizerLog::levels)
                 : std::vector<double>();
      !levels.empty())
    problem.grid = restored_steps(problem.stepper.ladder(), levels);
  choose_steps(problem, console);
  ControlProblem control_problem(problem, console);
  OptimizerLog record(control_problem, problem, folder, resume, console);
  std::vector<io::CoarseLevel> levels;
  const Result ending = minimise(problem, control_problem, record, console, levels);
  record.end();
  if (!record.evaluated()) // rows of a checkpoint alone are no result
    throw Interrupted();
  write_optimum(folder, problem, scene, control_problem, record,
                {.stop = ending.stop, .first_norm = ending.first_norm, .levels = std::move(levels)}, console);
  return ending.stop == optimize::Stop::solver_failed ? exit_status::solver_failed
         : ending.stop == optimize::Stop::interrupted ? exit_status::interrupted
                                                      : exit_status::done;
}

} // namespace signorini
