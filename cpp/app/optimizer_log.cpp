// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/optimizer_log.h"
#include "base/collective.h"
#include <cmath>
#include <fmt/format.h>

namespace signorini {

namespace {

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
      file_(folder.path() / resume::checkpoint), files_(files), every_(problem.scene.optimizer.checkpoint),
      resumes_(resume && resume::found(folder, console)) {
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
  if (reference_norm_ > 0) {
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
  resume::store_problem(out, scene::echo(scene_, problem_.space.dim()), problem_.mesh);
  out(solver, std::string(problem_.stepper.solver().iterates() ? iterative : "direct"));
  out("edges", edges(control_problem_.controls));
  out(levels, problem_.grid.levels());
  out("history", flat(rows_));
  out("seconds", seconds());
  out("sweeps",
      std::vector<double>{static_cast<double>(marked_.forward), static_cast<double>(marked_.adjoint)});
  out("kink", kink_ ? numbers(*kink_) : std::vector<double>());
}

void OptimizerLog::read(io::CheckpointReader& in) {
  resume::require_same_problem(in, scene::echo(scene_, problem_.space.dim()), problem_.mesh);
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
  resume::require_same_value(file_, stored, found, std::abs(stored));
  evaluated_ = true;
  control_problem_.reduced.count_from(marked_); // those since are made again
  stored_at_ = rows_.back().iteration;
  start_ = Clock::now();
  progress_.emplace(console_, "iterations", static_cast<std::size_t>(problem_.scene.optimizer.max_iterations),
                    static_cast<std::size_t>(stored_at_));
  console_.line(fmt::format("resumed after iteration {}", stored_at_));
  show_row();
}

} // namespace signorini
