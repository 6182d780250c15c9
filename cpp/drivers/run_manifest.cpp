// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/run_manifest.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/machine.h"
#include "scene/drop.h"
#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace signorini::drivers {

std::string body_lines(const problem::Problem& problem) {
  const diagnostics::BodyFigures figures = diagnostics::body_figures(problem.stepper, problem.scene);
  std::string text = figures.line();
  for (const std::string& note : figures.notes)
    text += "\nnote: " + note;
  for (const std::string& warning : figures.warnings)
    text += "\nwarning: " + warning;
  return text;
}

namespace {

/// Line on the speed of a body that is dropped; empty otherwise.
std::string drop_line(const scene::Scene& scene) {
  return scene.initial.drop ? fmt::format("\ndropped from {:.6g} m: touches at {:.6g} m/s",
                                          scene.initial.drop->height, scene::fall(scene).speed)
                            : "";
}

} // namespace

std::string headline(const problem::Problem& problem) {
  const int size = ranks(problem.space.comm());
  std::string on;
  for (const auto& [name, active] : io::effects(problem.scene))
    if (active)
      on += (on.empty() ? "" : ", ") + name;
  const step::TimeGrid& grid = problem.grid;
  const std::string steps =
      problem.scene.time.until_bounce ? fmt::format("steps of {} s to the end of the bounce, at most {}",
                                                    problem.scene.time.step, grid.steps())
      : grid.equal()
          ? fmt::format("{} steps of {} s", grid.steps(), problem.scene.time.step)
          : fmt::format("steps of {:.3g} s to {:.3g} s", problem.stepper.step_lengths()->shortest_step(),
                        problem.stepper.step_lengths()->longest_step());
  return fmt::format("{}: {} free unknowns, {} contact candidates, {}, {} "
                     "rank{}{}\n{}\neffects: {}\nsolver: {}",
                     problem.scene.name, problem.free_dofs(), trajectory::candidates(problem.stepper), steps,
                     size, size == 1 ? "" : "s",
                     threads() == 1 ? "" : fmt::format(" of {} threads", threads()),
                     body_lines(problem) + drop_line(problem.scene), on.empty() ? "none" : on,
                     problem.stepper.solver().choice());
}

std::vector<scene::TableWarning> series_warnings(MPI_Comm comm, const scene::Scene& scene) {
  std::vector<scene::TableWarning> found;
  for (const scene::NamedSeries& one : scene::time_series(scene)) {
    try {
      std::string text;
      on_root(comm, [&] { text = scene::read_file(one.file); });
      const scene::TableColumn column = scene::read_column(broadcast(comm, text), one.column);
      for (scene::TableWarning& warning : scene::input_warnings(column, scene.time.end)) {
        warning.message = fmt::format("{}: {}: {}", one.key, one.file.string(), warning.message);
        found.push_back(std::move(warning));
      }
    } catch (const UserError&) { // the file is gone or has changed since the scene was read
    }
  }
  return found;
}

void print_table_warnings(const std::vector<scene::TableWarning>& warnings, const Console& console) {
  for (const scene::TableWarning& warning : warnings)
    console.line("warning: " + warning.message);
}

void add_table_warnings(io::Manifest& manifest, const std::vector<scene::TableWarning>& warnings) {
  for (const scene::TableWarning& warning : warnings)
    manifest.warnings.push_back({"table", warning.message, warning.value, warning.limit});
}

void keep_mesh(const io::OutputFolder& folder, mesh::Meshing& meshing, scene::Scene& written) {
  constexpr const char* name = "mesh.msh";
  meshing.keep = folder.staged(name);
  written.mesh.file = folder.path() / name;
  written.mesh.size.reset();
  written.mesh.scale = 1;
}

io::Manifest manifest(const problem::Problem& problem, const std::string& verb,
                      const std::string& stop_reason, int steps_done) {
  io::Manifest m;
  m.verb = verb;
  m.stop_reason = stop_reason;
  m.ranks = ranks(problem.space.comm());
  m.unknowns = static_cast<long>(problem.space.dofs());
  m.free_unknowns = problem.free_dofs();
  m.cells = static_cast<long>(problem.mesh.cells());
  m.candidates = trajectory::candidates(problem.stepper);
  const step::TimeGrid& grid = problem.grid;
  m.steps_done = steps_done;
  m.steps_asked = grid.steps();
  m.wave_time = problem.stepper.wave_time();
  if (!grid.equal()) {
    io::StepStatistics& lengths = m.lengths.emplace();
    lengths.shortest = grid.end();
    for (int k = 1; k <= grid.steps(); ++k) {
      lengths.shortest = std::min(lengths.shortest, grid.length(k));
      lengths.longest = std::max(lengths.longest, grid.length(k));
    }
    lengths.factorisations = problem.stepper.factorisations();
    lengths.seconds = problem.stepper.factorisation_seconds();
  }
  m.dim = problem.space.dim();
  m.body = diagnostics::body_figures(problem.stepper, problem.scene);
  if (const auto& control = problem.scene.control)
    m.control_unit =
        control->on && problem.mesh.group_dimension(*control->on, "control.on") < problem.mesh.dim() ? "N/m²"
                                                                                                     : "N/m³";
  add_table_warnings(m, series_warnings(problem.space.comm(), problem.scene));
  m.solver = problem.stepper.solver().choice();
  m.peak_memory = peak_memory();
  MPI_Allreduce(MPI_IN_PLACE, &m.peak_memory, 1, MPI_DOUBLE, MPI_SUM, problem.space.comm());
  return m;
}

void finish(io::OutputFolder& folder, const Console& console) {
  if (const std::vector<std::string> outdated = folder.publish(); !outdated.empty())
    console.line(
        fmt::format("removed, since they belonged to the previous run: {}", fmt::join(outdated, ", ")));
  console.line(fmt::format("results in {}", folder.path().string()));
}

void add_watched(io::Manifest& manifest, MotionWriter& recorder, const scene::Run& run,
                 const Console& console) {
  if (const diagnostics::ImpactSummary* summary = recorder.summary()) {
    manifest.energy = summary->energy();
    manifest.impact = summary->impact();
  }
  manifest.von_mises = recorder.von_mises();
  manifest.probes = recorder.probe_peaks();
  manifest.stored = static_cast<int>(recorder.stored().size());
  if (recorder.invariants())
    manifest.invariants.assign(recorder.invariants()->defects().begin(),
                               recorder.invariants()->defects().end());
  for (const diagnostics::Invariants::Defect& defect : manifest.invariants)
    if (run.watched() && !(defect.worst <= run.tolerance))
      console.line(fmt::format("warning: {} is {:.2e} at step {}, above run.tolerance = {:.0e}", defect.name,
                               defect.worst, defect.step, run.tolerance));
  for (Warning& warning : recorder.warnings()) {
    console.line("warning: " + warning.message);
    manifest.warnings.push_back(std::move(warning));
  }
}

void add_warning(io::Manifest& manifest, std::optional<Warning> warning, const Console& console) {
  if (!warning)
    return;
  console.line("warning: " + warning->message);
  manifest.warnings.push_back(*std::move(warning));
}

} // namespace signorini::drivers
