#include "run.h"
#include "base/collective.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/signals.h"
#include "check.h"
#include "info.h"
#include "io/manifest.h"
#include "io/output_folder.h"
#include "optimize/lbfgs.h"
#include "optimize/newton_cg.h"
#include "optimize/projected_gradient.h"
#include "record.h"
#include <chrono>
#include <fmt/format.h>

namespace signorini {
namespace {

constexpr int done = 0, solver_failed = 3, interrupted = 130;

MPI_Comm world() { return MPI_COMM_WORLD; }

std::string headline(const Problem& problem) {
  const int size = ranks(world());
  std::string on;
  for (const auto& [name, active] : io::effects(problem.scene))
    if (active)
      on += (on.empty() ? "" : ", ") + name;
  return fmt::format(
      "{}: {} free unknowns, {} contact candidates, {} steps of {} s, {} rank{}\neffects: {}\nsolver: {}",
      problem.scene.name, problem.free_dofs(),
      problem.stepper.constraints() ? problem.stepper.constraints()->count() : 0, problem.steps(),
      problem.scene.time.step, size, size == 1 ? "" : "s", on.empty() ? "none" : on,
      problem.stepper.solver().choice());
}

io::Manifest manifest(const Problem& problem, const std::string& verb, const std::string& stop_reason,
                      int steps_done) {
  io::Manifest m;
  m.verb = verb;
  m.stop_reason = stop_reason;
  m.ranks = ranks(world());
  m.unknowns = static_cast<long>(problem.space.dofs());
  m.free_unknowns = problem.free_dofs();
  m.cells = static_cast<long>(problem.mesh.cells());
  m.candidates = problem.stepper.constraints() ? problem.stepper.constraints()->count() : 0;
  m.steps_done = steps_done;
  m.solver = problem.stepper.solver().choice();
  m.peak_memory = peak_memory();
  MPI_Allreduce(MPI_IN_PLACE, &m.peak_memory, 1, MPI_DOUBLE, MPI_SUM, world());
  return m;
}

void finish(io::OutputFolder& folder, const Console& console) {
  folder.publish();
  console.line(fmt::format("results in {}", folder.path().string()));
}

/// What the recorder watched, and a warning for each invariant that is off.
std::vector<forward::Invariants::Defect> watched(const Recorder& recorder, const scene::Run& run,
                                                 const Console& console) {
  std::vector<forward::Invariants::Defect> defects;
  if (recorder.invariants())
    defects.assign(recorder.invariants()->defects().begin(), recorder.invariants()->defects().end());
  for (const forward::Invariants::Defect& defect : defects)
    if (run.watched() && !(defect.worst <= run.tolerance))
      console.line(fmt::format("warning: {} is {:.2e} at step {}, allowed is {:.0e} (run.tolerance)",
                               defect.name, defect.worst, defect.step, run.tolerance));
  return defects;
}

int simulate_scene(const scene::Scene& scene, const std::filesystem::path& out, const Console& console) {
  io::OutputFolder folder(world(), out);
  Timers timers;
  const Problem problem(world(), scene, {.sliding = false}, timers);
  console.line(headline(problem));

  const GivenControl given(problem);
  const forward::Load load = given.load();
  Recorder recorder(problem, folder, nullptr);
  int steps = 0;
  {
    const auto timer = timers.time("forward");
    Progress progress(console, "steps", static_cast<std::size_t>(problem.steps()));
    steps = forward::stream(problem.stepper, problem.initial, load, problem.steps(),
                            [&](const forward::Frame& frame) {
                              recorder(frame);
                              progress.update(static_cast<std::size_t>(frame.k));
                            });
  }
  if (steps == 0) // nothing that could stand in for an earlier run's results
    throw Interrupted();
  const bool complete = steps == problem.steps();
  recorder.finish();
  folder.write("scene.toml", scene::echo(scene, problem.space.dim()));
  io::Manifest m = manifest(problem, "simulate", complete ? "end of time" : "interrupted", steps);
  m.invariants = watched(recorder, scene.run, console);
  folder.write("run.json", io::to_json(m, scene, timers));
  console.line(fmt::format("{}{} steps in {:.2g} s", complete ? "" : "interrupted after ", steps,
                           timers.entries().at("forward").seconds));
  finish(folder, console);
  return complete ? done : interrupted;
}

/// Collects history.csv and reports progress.
class History {
public:
  History(const ControlProblem& problem, const scene::Optimizer& options, const Console& console)
      : problem_(problem),
        progress_(console, "iterations", static_cast<std::size_t>(options.max_iterations)) {}

  void operator()(const optimize::Iteration& iteration) {
    const control::ReducedProblem& reduced = problem_.reduced;
    const control::Value& value = reduced.value();
    io::HistoryRow row{
        iteration.number,         value.total(),
        value.tracking,           value.terminal,
        value.control_cost,       iteration.gradient_norm,
        iteration.step_length,    reduced.sweeps().forward,
        reduced.sweeps().adjoint, std::chrono::duration<double>(Clock::now() - start_).count()};
    if (problem_.reference) {
      control::Control difference = reduced.control();
      difference.add(-1, *problem_.reference);
      row.relative_distance_to_reference =
          problem_.controls.norm(difference) / problem_.controls.norm(*problem_.reference);
    }
    rows_.push_back(row);
    progress_.update(static_cast<std::size_t>(iteration.number),
                     fmt::format("J = {:.6e}  |g| = {:.2e}", row.objective, row.gradient_norm));
  }

  [[nodiscard]] const std::vector<io::HistoryRow>& rows() const { return rows_; }

private:
  using Clock = std::chrono::steady_clock;
  const ControlProblem& problem_;
  Progress progress_;
  Clock::time_point start_ = Clock::now();
  std::vector<io::HistoryRow> rows_;
};

/// steps.csv, contact.csv, state.xdmf. Returns how well the motion keeps what it should.
std::vector<forward::Invariants::Defect> write_motion(const io::OutputFolder& folder, const Problem& problem,
                                                      const control::ReducedProblem& reduced,
                                                      const Console& console) {
  Recorder recorder(problem, folder, &reduced.objective());
  if (recorder.wanted()) {
    const auto timer = problem.timers.time("replay");
    forward::stream(problem.stepper, problem.initial, reduced.load(), problem.steps(), std::ref(recorder),
                    forward::Stops::ignored);
  }
  recorder.finish();
  return watched(recorder, problem.scene.run, console);
}

/// control.xdmf and adjoint.xdmf.
void write_control(const io::OutputFolder& folder, const Problem& problem,
                   const control::ReducedProblem& reduced) {
  const auto timer = problem.timers.time("output");
  const scene::Output& output = problem.scene.output;
  std::vector<int> steps;
  for (int k = 1; k <= problem.steps(); ++k)
    if (stored(k, output.every, k == problem.steps()))
      steps.push_back(k);
  using enum io::FieldFile::Values;
  const auto write = [&](const std::string& name, io::FieldFile::Values values, auto&& at) {
    if (!output.field(name))
      return;
    io::FieldFile file(problem.space, folder, name + ".xdmf", steps.size(), values);
    at([&](int k, Vec x) { file.write(name, x, problem.stepper.scheme().time(k)); });
    file.close();
  };
  write("control", reduced.controls().cellwise() ? cellwise : nodal, [&](auto&& store) {
    const petsc::Vector field = reduced.controls().field();
    for (int k : steps) {
      reduced.controls().extend(reduced.control().at(k), field);
      store(k, field);
    }
  });
  write("adjoint", nodal, [&](auto&& store) {
    const petsc::Series states = reduced.adjoint_states(steps);
    for (std::size_t i = 0; i < steps.size(); ++i)
      store(steps[i], states[i]);
  });
}

/// How the states of motions were kept, and what that took.
std::string storage_line(const Problem& problem, const ControlProblem& control_problem) {
  const auto seconds = [&](const char* phase) {
    const auto found = problem.timers.entries().find(phase);
    return found == problem.timers.entries().end() ? 0.0 : found->second.seconds;
  };
  const std::string& kept = problem.scene.trajectory.storage;
  const double bytes = control_problem.storage.bytes();
  const std::string room = fmt::format("{:.3g} MB", bytes * 1e-6);
  if (kept == "disk")
    return fmt::format("states on disk, {} a motion: written in {:.1f} s, read in {:.1f} s", room, seconds("states written"),
                       seconds("states read"));
  if (kept == "checkpoints")
    return fmt::format("states in checkpoints of {:.3g} MB: {} steps made again in {:.1f} s",
                       bytes * 1e-6 * (control_problem.reference ? 2 : 1), count("recomputed steps"),
                       seconds("states recomputed"));
  return fmt::format("states in memory, {} a motion", room);
}

int optimize_scene(const scene::Scene& scene, const std::filesystem::path& out, const Console& console) {
  if (!scene.objective)
    throw UserError(
        fmt::format("{}: optimize needs the tables [control] and [objective], and the scene has {}",
                    scene.file.string(), scene.control ? "no objective" : "neither"));
  if (const auto* run = std::get_if<scene::DesiredRun>(&scene.objective->desired))
    on_root(world(), [&] {
      std::error_code missing;
      if (std::filesystem::equivalent(out, run->folder, missing))
        throw UserError(
            fmt::format("--out: found the folder of objective.desired.run, {}, whose files this run "
                        "would replace, allowed is another",
                        run->folder.string()));
    });
  io::OutputFolder folder(world(), out);
  Timers timers;
  const Problem problem(world(), scene, {.sliding = true}, timers);
  console.line(headline(problem));
  ControlProblem control_problem(problem, console);
  control::ReducedProblem& reduced = control_problem.reduced;

  // A control is of the order of one by its scale; the first step is as long as a control of one throughout.
  const control::Control one = control_problem.controls.constant(1);
  const optimize::Options options{.max_iterations = scene.optimizer.max_iterations,
                                  .tolerance = scene.optimizer.tolerance,
                                  .first_step = control_problem.controls.norm(one)};
  optimize::Ending<control::Control> ending{};
  std::vector<io::HistoryRow> rows;
  {
    History history(control_problem, scene.optimizer, console);
    control::Control guess = control_problem.first_guess(scene);
    const std::string& method = scene.optimizer.method;
    ending = method == "lbfgs" ? optimize::lbfgs(reduced, std::move(guess), options, history)
           : method == "newton-cg"
               ? optimize::newton_cg(reduced, std::move(guess), options, history)
               : optimize::projected_gradient(reduced, std::move(guess), options, history);
    rows = history.rows();
  }
  const optimize::Stop stop = ending.stop;
  if (rows.empty()) // interrupted before the first guess was evaluated: there is nothing to write
    throw Interrupted();

  if (scene.output.table("history"))
    folder.write("history.csv", io::history_table(rows));
  folder.write("scene.toml", scene::echo(scene, problem.space.dim()));
  const auto invariants = write_motion(folder, problem, reduced, console);
  write_control(folder, problem, reduced);
  io::Manifest m = manifest(problem, "optimize", optimize::name(stop), reduced.trajectory().steps());
  m.invariants = invariants;
  m.objective = reduced.value();
  m.iterations = rows.back().iteration;
  m.forward_sweeps = reduced.sweeps().forward;
  m.adjoint_sweeps = reduced.sweeps().adjoint;
  folder.write("run.json", io::to_json(m, scene, timers));
  console.line(fmt::format(
      "stopped: {}\nJ {:.6e} -> {:.6e} (tracking {:.3e}, terminal {:.3e}, control {:.3e}), |g| "
      "{:.2e} -> {:.2e} (tolerance {:.2e})\n{} iterations, {} forward and {} adjoint sweeps in {:.1f} s",
      optimize::name(stop), rows.front().objective, m.objective->total(), m.objective->tracking,
      m.objective->terminal, m.objective->control_cost, rows.front().gradient_norm, rows.back().gradient_norm,
      scene.optimizer.tolerance * rows.front().gradient_norm, rows.back().iteration, *m.forward_sweeps,
      *m.adjoint_sweeps, rows.back().seconds));
  console.line(storage_line(problem, control_problem));
  finish(folder, console);
  return stop == optimize::Stop::solver_failed ? solver_failed
         : stop == optimize::Stop::interrupted ? interrupted
                                               : done;
}

int check(const scene::Scene& scene, const Console& console) {
  Timers timers;
  const Problem problem(world(), scene, {.sliding = scene.objective.has_value()}, timers);
  console.line(headline(problem));
  return check_scene(problem, console) ? done : 1;
}

} // namespace

int run(const Request& request, const Console& console) {
  std::string text; // read once: ranks that saw different scenes would wait for each other for ever
  on_root(world(), [&] { text = scene::read(request.scene); });
  const scene::Scene scene = scene::parse(broadcast(world(), text), request.scene, request.overrides);
  const std::filesystem::path out =
      !request.out.empty()
          ? request.out
          : std::filesystem::path("results") / (request.verb == "study" ? scene.name + "-study" : scene.name);
  catch_stop_signals();
  if (request.verb == "simulate")
    return simulate_scene(scene, out, console);
  if (request.verb == "optimize")
    return optimize_scene(scene, out, console);
  if (request.verb == "check")
    return check(scene, console);
  if (request.verb == "study")
    return request.suggest ? study::suggest(world(), scene, *request.suggest, request.study.budget, console)
                           : study::run_study(world(), scene, out, request.study, console);
  Timers timers;
  const Problem problem(world(), scene, {.sliding = scene.objective.has_value()}, timers);
  tell(problem, request.timed_steps, console);
  return done;
}

} // namespace signorini
