// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/search_results.h"
#include "base/timers.h"
#include "diagnostics/warnings.h"
#include "drivers/fit_outcome.h"
#include "drivers/motion_writer.h"
#include "drivers/run_manifest.h"
#include "problem/scenarios.h"
#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace signorini::drivers {
namespace {

/// Problem and forces at the point that a search found.
class SearchPoint {
public:
  SearchPoint(const SearchSubject& subject, const SearchEnd& end) {
    if (subject.parameters) {
      scene_ = subject.parameters->scene_at(end.fitted ? end.fitted->x : subject.reduced.variables().x);
      own_.emplace(subject.parameters->discretisation, *scene_, subject.parameters->needs(), subject.timers,
                   trajectory::Stops::ignored);
    }
    problem_ = own_ ? &*own_ : subject.problem;
    if (subject.control)
      force_.emplace(subject.control->controls, subject.reduced.control());
    else
      given_.emplace(*problem_);
  }
  SearchPoint(const SearchPoint&) = delete; // its parts refer to each other
  SearchPoint& operator=(const SearchPoint&) = delete;

  [[nodiscard]] const problem::Problem& problem() const { return *problem_; }
  [[nodiscard]] step::ForceAtStep load() const { return given_ ? given_->load() : problem_->load(&*force_); }

private:
  std::optional<scene::Scene> scene_;
  std::optional<problem::Problem> own_;
  const problem::Problem* problem_;
  std::optional<control::ControlForce> force_;
  std::optional<problem::GivenControl> given_;
};

/// Line on how the states of motions were stored, and on the memory and time for that.
std::string storage_line(const problem::Problem& problem, const problem::ControlProblem& control_problem) {
  const auto seconds = [&](const char* phase) {
    const auto found = problem.timers.entries().find(phase);
    return found == problem.timers.entries().end() ? 0.0 : found->second.seconds;
  };
  const scene::Storage kept = problem.scene.trajectory.storage;
  const double bytes = control_problem.storage.bytes();
  const std::string room = fmt::format("{:.3g} MB", bytes * 1e-6);
  if (kept == scene::Storage::disk)
    return fmt::format("states on disk, {} for each motion: written in {:.1f} s, read in {:.1f} s", room,
                       seconds("states written"), seconds("states read"));
  if (kept == scene::Storage::checkpoints)
    return fmt::format("states in checkpoints, {:.3g} MB in all: {} steps recomputed in {:.1f} s",
                       bytes * 1e-6 * (control_problem.reference ? 2 : 1), count("recomputed steps"),
                       seconds("states recomputed"));
  return fmt::format("states in memory, {} for each motion", room);
}

/// Advice on continuing a search that was interrupted or reached its iteration limit; else empty.
std::string continuation(optimize::Stop stop, const SearchSubject& subject) {
  if (!subject.problem || subject.scene.optimizer.checkpoint == 0)
    return "";
  return stop == optimize::Stop::interrupted ? "; the same command with --resume continues from here"
         : stop == optimize::Stop::iteration_limit
             ? "; the same command with --resume and a larger optimizer.max_iterations continues from here"
             : "";
}

std::string words(optimize::Stop stop, const SearchEnd& end) {
  return end.fitted && stop == optimize::Stop::gradient_tolerance ? "decrement below tolerance"
                                                                  : optimize::name(stop);
}

/// Prints a description of the kink at which a search ended.
void show(const io::Kink& kink, const SearchSubject& subject, double first_norm, const Console& console) {
  const auto scenario = [&](int motion) -> std::string {
    for (std::size_t i = 0; i < subject.scene.scenarios.size(); ++i)
      if (subject.control->scenarios->number(i) == static_cast<std::size_t>(motion))
        return fmt::format(" of \"{}\"", subject.scene.scenarios[i].name);
    return "";
  };
  std::string text = fmt::format(
      "no direction lowers J. {} gradients within {:.1e} of the control in L2 have a convex combination of "
      "norm {:.2e}, {:.1e} times the first gradient norm. ",
      kink.gradients, kink.radius, kink.length, kink.length / first_norm);
  text +=
      kink.weak.empty()
          ? std::string("At all these points the same candidates touch, but not nearer to the control: "
                        "forces chatter there")
          : fmt::format("Between these points contact differs at {} candidates and steps, where it is weak:",
                        kink.weak.size());
  console.line(text);
  constexpr std::size_t most_lines = 8;
  for (std::size_t i = 0; i < std::min(most_lines, kink.weak.size()); ++i)
    console.line(fmt::format("  step {}{} (t = {:.6g} s), node at ({:.6g}) m", kink.weak[i].step,
                             scenario(kink.weak[i].motion), kink.weak[i].time,
                             fmt::join(kink.weak[i].x, ", ")));
  if (kink.weak.size() > most_lines)
    console.line(fmt::format("  and {} more; run.json lists all", kink.weak.size() - most_lines));
}

/// Warns if a search ended without a minimum where candidates open and close from step to step, so that J
/// consists of many short smooth parts.
void add_chatter(io::Manifest& manifest, const control::ReducedProblem& reduced, const Console& console) {
  const diagnostics::Alternations found = diagnostics::alternations(reduced.trajectory().contact());
  const std::string other = diagnostics::calmer_contact(reduced.stepper());
  if (found.alternating == 0)
    return;
  manifest.warnings.push_back(
      {"search among chattering contact",
       fmt::format("the search found no further decrease of J, since contact chatters. Candidates open or "
                   "close for a single step {} times. The number of closed candidates, summed over all "
                   "steps, is {}; {}",
                   found.alternating, found.closed, other),
       static_cast<double>(found.alternating), 0});
  console.line("warning: " + manifest.warnings.back().message);
}

/// Writes the files of the motion. If parameters are sought, returns the simulated measurements.
Simulated write_motion(const SearchSubject& subject, const SearchPoint& found, MotionWriter& recorder) {
  const problem::Problem& problem = found.problem();
  if (subject.parameters)
    return simulate_measured(problem, *subject.parameters, found.load(), recorder);
  const auto timer = problem.timers.time("replay");
  trajectory::integrate(problem.stepper, problem.grid, problem.initial, found.load(), std::ref(recorder),
                        trajectory::Stops::ignored);
  recorder.finish();
  return {};
}

/// Collects the fitted parameters, and how well the data determine them.
io::Fit fitted(const SearchSubject& subject, const SearchLog& log, const SearchEnd& end,
               Simulated simulated) {
  const problem::ParameterProblem& parameters = *subject.parameters;
  if (end.fitted) {
    io::Fit fit = outcome(parameters, *end.fitted, simulated.values);
    fit.compared = std::move(simulated.compared);
    return fit;
  }
  control::ReducedProblem& reduced = subject.reduced;
  const std::vector<double>& x = reduced.variables().x;
  const auto sweeps = reduced.sweeps(); // sweeps for output do not count
  io::Fit fit = outcome(parameters,
                        {.number = static_cast<int>(log.history().last("iteration")),
                         .x = x,
                         .at = reduced.least_squares(reduced.variables(), trajectory::Stops::ignored)},
                        simulated.values);
  fit.compared = std::move(simulated.compared);
  fit.decrement.reset(); // it leaves out the control's part of J
  const std::vector<double> by_x = reduced.gradient_by_parameters(), slopes = parameters.misfit.slopes(x);
  for (std::size_t j = 0; j < x.size(); ++j)
    fit.unknowns[j].gradient = by_x[j] / slopes[j];
  reduced.restore_sweeps(sweeps);
  return fit;
}

/// Line with J, its parts and the cost of the search.
std::string end_line(const SearchSubject& subject, const SearchLog& log, const SearchEnd& end) {
  const io::History& history = log.history();
  const control::ReducedProblem::Sweeps sweeps = subject.reduced.sweeps();
  const double iterations = history.last("iteration"), J = history.last("objective");
  if (end.fitted)
    return fmt::format("J {:.6e}: {} iterations, {} forward sweeps in {:.1f} s", J, iterations,
                       sweeps.forward, log.seconds());
  const control::ObjectiveValue& value = subject.reduced.value();
  const std::string parts = fmt::format("tracking {:.3e}, terminal {:.3e}, control {:.3e}", value.tracking,
                                        value.terminal, value.control_cost),
                    cost = fmt::format("{} iterations, {} forward and {} adjoint sweeps in {:.1f} s",
                                       iterations, sweeps.forward, sweeps.adjoint, history.last("seconds"));
  if (subject.parameters)
    return fmt::format("J {:.6e} ({}, misfit {:.3e}): {}", J, parts, value.misfit, cost);
  return fmt::format("J {:.6e} -> {:.6e}{} ({}), |g| {:.2e} -> {:.2e} (tolerance {:.2e})\n{}",
                     history.at(0, "objective"), J,
                     end.levels.empty() ? "" : " on this mesh, from the optimum of a coarser one", parts,
                     history.at(0, "gradient_norm"), history.last("gradient_norm"),
                     *subject.scene.optimizer.tolerance * end.first_norm, cost);
}

/// Returns the scenarios at the control that was found, in the order of the scene; empty without scenarios.
std::vector<io::ScenarioResult> scenario_results(const SearchSubject& subject) {
  std::vector<io::ScenarioResult> results;
  const auto* reduced = dynamic_cast<const control::ScenarioProblem*>(&subject.reduced);
  if (!reduced)
    return results;
  const std::vector<control::ObjectiveValue> values = reduced->values();
  for (std::size_t i = 0; i < subject.scene.scenarios.size(); ++i) {
    const std::size_t s = subject.control->scenarios->number(i);
    results.push_back({.name = subject.scene.scenarios[i].name,
                       .weight = reduced->weights()[s],
                       .share = reduced->shares()[s],
                       .value = values[s]});
  }
  return results;
}

/// Line with the range of J over the scenarios.
std::string scenarios_line(const std::vector<io::ScenarioResult>& results) {
  const auto of = [](const io::ScenarioResult& one) { return one.value.total(); };
  const auto [least, most] = std::ranges::minmax_element(results, {}, of);
  return fmt::format("J of the scenarios: {:.6e} ({}) to {:.6e} ({})", of(*least), least->name, of(*most),
                     most->name);
}

/// Writes the tables of a search, and its scene.
void write_tables(io::OutputFolder& folder, const SearchSubject& subject, const SearchLog& log,
                  const std::optional<io::Fit>& fit, const std::vector<io::ScenarioResult>& scenarios) {
  const scene::Output& output = subject.scene.output;
  if (output.table(scene::StoredTable::history))
    folder.write("history.csv", log.history().table());
  if (fit && output.table(scene::StoredTable::parameters))
    folder.write("parameters.csv", io::parameters_table(*fit));
  if (fit && output.table(scene::StoredTable::measurements))
    folder.write("measurements.csv", io::measurements_table(*fit));
  if (!scenarios.empty() && output.table(scene::StoredTable::scenarios))
    folder.write("scenarios.csv", io::scenarios_table(scenarios));
  folder.write("scene.toml", scene::echo(subject.scene, subject.discretisation.space.dim()));
}

/// Adds the entries of a search to run.json, and prints its warnings.
void add_search(io::Manifest& m, const SearchSubject& subject, const SearchLog& log, SearchEnd& end,
                const Console& console) {
  const control::ReducedProblem& reduced = subject.reduced;
  if (subject.control) {
    m.objective = reduced.value();
    m.objective->misfit = 0; // it is part of the fit
    if (end.stop == optimize::Stop::no_decrease)
      add_chatter(m, reduced, console);
  }
  m.iterations = static_cast<int>(log.history().last("iteration"));
  m.forward_sweeps = reduced.sweeps().forward;
  m.adjoint_sweeps = reduced.sweeps().adjoint;
  m.accuracy = std::move(end.accuracy);
  m.coarse_levels = std::move(end.levels);
  if (end.stop == optimize::Stop::kink) {
    m.kink = log.final_kink().value();
    show(*m.kink, subject, end.first_norm, console);
  }
}

} // namespace

void write_results(io::OutputFolder& folder, SearchLog& log, SearchEnd end, const Console& console) {
  const SearchSubject& subject = log.subject();
  const SearchPoint found(subject, end);
  const problem::Problem& problem = found.problem();
  control::ReducedProblem& reduced = subject.reduced;
  MotionWriter recorder(problem, folder, subject.control ? &subject.control->objective : nullptr, true);
  Simulated simulated = write_motion(subject, found, recorder);
  if (subject.control)
    write_control(
        folder, problem, reduced.controls(), reduced.control(),
        [&](const auto& store) { reduced.adjoint_states(store); }, recorder.stored());
  std::optional<io::Fit> fit;
  if (subject.parameters)
    fit = fitted(subject, log, end, std::move(simulated));
  std::vector<io::ScenarioResult> scenarios = scenario_results(subject);
  write_tables(folder, subject, log, fit, scenarios);
  console.line("stopped: " + words(end.stop, end) + continuation(end.stop, subject));
  const bool failed = end.stop == optimize::Stop::solver_failed || end.stop == optimize::Stop::no_decrease;
  if (failed && !end.failure.empty())
    console.line("last failed trial: " + end.failure);
  if (fit)
    for (const std::string& line : outcome_lines(*fit))
      console.line(line);
  io::Manifest m = manifest(problem, "optimize", words(end.stop, end), problem.steps());
  if (subject.parameters)
    add_table_warnings(m, subject.parameters->misfit.warnings());
  add_watched(m, recorder, subject.scene.run, console);
  add_warning(m, problem::desired_run_spacing_warning(problem), console);
  if (fit)
    add_warning(m, misfit_warning(*fit), console);
  add_search(m, subject, log, end, console);
  m.fit = std::move(fit);
  m.scenarios = scenarios;
  m.files = folder.files();
  folder.write("run.json", io::to_json(m, subject.scene, problem.timers));
  console.line(end_line(subject, log, end));
  if (!scenarios.empty())
    console.line(scenarios_line(scenarios));
  if (subject.problem && !subject.parameters)
    console.line(storage_line(problem, *subject.control));
  finish(folder, console);
}

} // namespace signorini::drivers
