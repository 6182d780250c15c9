// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/optimizer_log.h"
#include "base/collective.h"
#include "base/error.h"
#include "scene/compatibility.h"
#include "version.h"
#include <cmath>
#include <fmt/format.h>

namespace signorini {

namespace {

/// The version of the layout of checkpoint.h5.
constexpr int format = 5;

/// Numbers in a row of the history, as stored.
constexpr std::size_t columns = 11;

std::vector<double> flat(const std::vector<io::HistoryRow>& rows) {
  std::vector<double> numbers;
  for (const io::HistoryRow& r : rows)
    numbers.insert(numbers.end(),
                   {static_cast<double>(r.iteration), r.objective, r.tracking, r.terminal, r.control_cost,
                    r.gradient_norm, r.step_length, static_cast<double>(r.forward_sweeps),
                    static_cast<double>(r.adjoint_sweeps), r.seconds, r.relative_distance_to_reference});
  return numbers;
}

std::vector<io::HistoryRow> rows_of(const std::vector<double>& numbers) {
  std::vector<io::HistoryRow> rows;
  for (std::size_t i = 0; i + columns <= numbers.size(); i += columns) {
    const double* n = &numbers[i];
    rows.push_back({static_cast<int>(n[0]), n[1], n[2], n[3], n[4], n[5], n[6], static_cast<int>(n[7]),
                    static_cast<int>(n[8]), n[9], n[10]});
  }
  return rows;
}

} // namespace

OptimizerLog::OptimizerLog(ControlProblem& control_problem, const Problem& problem, const scene::Scene& scene,
                           const io::OutputFolder& folder, bool resume, const Console& console, Files files)
    : control_problem_(control_problem), problem_(problem), scene_(scene), folder_(folder), console_(console),
      file_(folder.path() / checkpoint), files_(files), every_(problem.scene.optimizer.checkpoint),
      resumes_(resume && found()) {
  progress_.emplace(console, "iterations", static_cast<std::size_t>(problem.scene.optimizer.max_iterations));
  if (control_problem.reference)
    reference_norm_ = control_problem.controls.norm(*control_problem.reference);
}

double OptimizerLog::seconds() const {
  return earlier_ + std::chrono::duration<double>(Clock::now() - start_).count();
}

void OptimizerLog::operator()(const optimize::Iteration& iteration) {
  evaluated_ = true;
  const control::ReducedProblem& reduced = control_problem_.reduced;
  const control::Value& value = reduced.value();
  io::HistoryRow row{iteration.number,         value.total(),
                     value.tracking,           value.terminal,
                     value.control_cost,       iteration.gradient_norm,
                     iteration.step_length,    reduced.sweeps().forward,
                     reduced.sweeps().adjoint, seconds()};
  if (control_problem_.reference) {
    control::Control difference = reduced.control();
    difference.add(-1, *control_problem_.reference);
    row.relative_distance_to_reference = control_problem_.controls.norm(difference) / reference_norm_;
  }
  rows_.push_back(row);
  show_row();
  progress_->update(static_cast<std::size_t>(iteration.number),
                    fmt::format("J = {:.6e}  |g| = {:.2e}  step {:.2g}", row.objective, row.gradient_norm,
                                row.step_length));
}

void OptimizerLog::show_row() {
  if (files_ == Files::with_results || rank(folder_.comm()) != 0 ||
      !problem_.scene.output.table(scene::StoredTable::history))
    return;
  if (history_.is_open()) {
    history_ << io::history_rows({rows_.back()}) << std::flush;
    return;
  }
  // The earlier run's file is replaced as a whole, by renaming.
  const std::filesystem::path part = folder_.staged("history.csv.part");
  history_.open(part, std::ios::binary);
  history_ << io::history_table(rows_) << std::flush;
  std::error_code ignored; // the whole table is written again, and checked, at the end
  if (history_)
    std::filesystem::rename(part, folder_.path() / "history.csv", ignored);
  if (!history_ || ignored)
    std::filesystem::remove(part, ignored);
}

bool OptimizerLog::found() const {
  int there = 0;
  if (rank(folder_.comm()) == 0)
    there = std::filesystem::exists(file_);
  MPI_Bcast(&there, 1, MPI_INT, 0, folder_.comm());
  if (!there)
    console_.line(fmt::format("no checkpoint in {}: starting from the first guess", folder_.path().string()));
  return there != 0;
}

namespace {

/// The times, in s, between which controls are constant.
std::vector<double> edges(const control::ControlSpace& controls) {
  std::vector<double> times;
  for (int j = 1; j <= controls.count() + 1; ++j)
    times.push_back(controls.begin(j));
  return times;
}

} // namespace

void OptimizerLog::write(io::CheckpointWriter& out) const {
  out("format", format);
  out("program", std::string("signorini ") + SIGNORINI_VERSION);
  out("scene", scene::echo(scene_, problem_.space.dim()));
  out(solver, std::string(problem_.stepper.solver().iterates() ? iterative : "direct"));
  out("edges", edges(control_problem_.controls));
  out(levels, problem_.stepper.grid().levels());
  out("history", flat(rows_));
  out("seconds", seconds());
  out("sweeps",
      std::vector<double>{static_cast<double>(marked_.forward), static_cast<double>(marked_.adjoint)});
  out("kink", kink_ ? numbers(*kink_) : std::vector<double>());
}

void OptimizerLog::read(io::CheckpointReader& in) {
  int found = 0;
  in("format", found);
  if (found != format)
    in.fail(fmt::format("found layout {}, allowed is {}, that of this version of signorini", found, format));
  std::string scene;
  in("scene", scene);
  const scene::Difference difference =
      scene::difference(scene, scene::echo(scene_, problem_.space.dim()), scene::Part::search);
  if (!difference.first.empty())
    in.fail(fmt::format("found a run with {}, this scene has {}; allowed is the scene that was interrupted",
                        difference.first, difference.second));
  in.match_places();
  std::vector<double> history;
  in("history", history);
  rows_ = rows_of(history);
  if (rows_.empty() || history.size() % columns != 0)
    in.fail("\"history\" is damaged; allowed is a whole checkpoint");
  in("seconds", earlier_);
  std::vector<double> sweeps, kink;
  in("sweeps", sweeps);
  if (sweeps.size() != 2)
    in.fail("\"sweeps\" is damaged; allowed is a whole checkpoint");
  marked_ = {static_cast<int>(sweeps[0]), static_cast<int>(sweeps[1])};
  in("kink", kink);
  if (!kink.empty()) {
    kink_ = kink_of(kink, problem_.space.dim());
    if (!kink_)
      in.fail("\"kink\" is damaged; allowed is a whole checkpoint");
  }
}

void OptimizerLog::restored(double stored, double found) {
  constexpr double other_ranks = 1e-6;
  if (!(std::abs(found - stored) <= other_ranks * std::abs(stored)))
    throw UserError(fmt::format(
        "--resume: {}: found a control with J = {:.10g}, where it was {:.10g}; allowed are the forms and the "
        "mesh of the run that was interrupted",
        file_.string(), found, stored));
  evaluated_ = true;
  control_problem_.reduced.count_from(marked_); // those since are made again
  stored_at_ = rows_.back().iteration;
  start_ = Clock::now();
  progress_.emplace(console_, "iterations", static_cast<std::size_t>(problem_.scene.optimizer.max_iterations),
                    static_cast<std::size_t>(stored_at_));
  console_.line(fmt::format("resumed after iteration {}", stored_at_));
  show_row();
}

std::string OptimizerLog::not_written(const std::string& failure) const {
  return fmt::format("warning: {} was not written ({}); the run goes on, and an earlier checkpoint stays",
                     file_.string(), failure);
}

} // namespace signorini
