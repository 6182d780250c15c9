// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "app/kink.h"
#include "app/problem.h"
#include "app/resume.h"
#include "io/checkpoint.h"
#include "io/csv_tables.h"
#include "io/output_folder.h"
#include "optimize/minimize.h"
#include <fstream>

namespace signorini {

/// Output of a search while it runs: progress, history.csv in the folder, one line for each iteration as soon
/// as it is made, and checkpoint.h5. All members collective.
class OptimizerLog {
public:
  /// The checkpoint's entry for the solver of the steps, and what that says of conjugate gradients.
  static constexpr const char *solver = "solver", *iterative = "iterative";
  static constexpr const char* levels = "levels"; ///< its entry for the lengths of steps, if they vary

  /// Whether files are in place while the search runs, or with its results.
  enum class Files { early, with_results };

  /// With `resume` the search continues from the folder's checkpoint, if there is one. The references must
  /// outlive this object.
  OptimizerLog(ControlProblem& control_problem, const Problem& problem, const io::OutputFolder& folder,
               bool resume, const Console& console)
      : OptimizerLog(control_problem, problem, problem.scene, folder, resume, console, Files::early) {}
  /// `scene`: as it is written into the folder.
  OptimizerLog(ControlProblem& control_problem, const Problem& problem, const scene::Scene& scene,
               const io::OutputFolder& folder, bool resume, const Console& console, Files files);

  /// Records an iterate, the problem's current point.
  void operator()(const optimize::Iteration& iteration);

  /// Whether the search continues from a checkpoint.
  [[nodiscard]] bool resumes() const { return resumes_; }

  /// Restores the state of the search; false if there is no checkpoint. Throws UserError if it is damaged or
  /// of another problem.
  template <class State>
  bool restore(State& state) {
    if (!resumes_)
      return false;
    io::CheckpointReader in(control_problem_.controls, file_);
    read(in);
    control::VariablesArchive archive(in, 0);
    state.serialize(archive);
    return true;
  }

  /// Compares J as stored in the checkpoint with J as evaluated now. Throws UserError if they differ by more
  /// than another number of ranks explains.
  void restored(double stored, double found);

  /// Whether a checkpoint is to be written after this iteration.
  [[nodiscard]] bool due(const optimize::Iteration& iteration) const {
    return every_ > 0 && iteration.number % every_ == 0 && iteration.number != stored_at_;
  }

  /// What is stored before the next mark is of now.
  void mark() { marked_ = control_problem_.reduced.sweeps(); }

  /// Takes what a certificate tells of the kink at which the search ends. Throws Interrupted.
  void certified(const optimize::Certificate<control::Variables>& certificate) {
    kink_ = describe(control_problem_.reduced, certificate);
  }
  /// The kink, if there was a certificate here or in the checkpoint.
  [[nodiscard]] const std::optional<io::Kink>& kink() const { return kink_; }

  /// Writes a checkpoint. A failure is reported and the search goes on: the last checkpoint stays.
  template <class State>
  void store(State& state) {
    if (every_ == 0 || rows_.empty())
      return;
    const auto timer = problem_.timers.time("checkpoint");
    io::CheckpointWriter out(control_problem_.controls, folder_.staged(resume::checkpoint), file_);
    write(out);
    control::VariablesArchive archive(out, 0);
    state.serialize(archive);
    stored_at_ = state.iteration.number;
    if (const std::string failure = out.commit(); !failure.empty())
      console_.line(resume::not_written(file_, failure));
  }

  /// Ends the display of progress.
  void end() { progress_.reset(); }

  /// The history of the whole search, iterations before it was resumed included.
  [[nodiscard]] const std::vector<io::HistoryRow>& rows() const { return rows_; }

  /// Whether the problem's current point is one of the search: J was evaluated at the first guess, or at the
  /// checkpoint's control.
  [[nodiscard]] bool evaluated() const { return evaluated_; }

private:
  using Clock = std::chrono::steady_clock;

  void read(io::CheckpointReader& in);
  void write(io::CheckpointWriter& out) const;
  /// Starts history.csv with the rows so far, or adds the last one.
  void show_row();
  [[nodiscard]] double seconds() const;

  ControlProblem& control_problem_;
  const Problem& problem_;
  const scene::Scene& scene_; ///< as it is written
  const io::OutputFolder& folder_;
  const Console& console_;
  std::filesystem::path file_;
  Files files_;
  int every_, stored_at_ = -1;
  bool resumes_, evaluated_ = false;
  std::optional<Progress> progress_;
  Clock::time_point start_ = Clock::now();
  double reference_norm_ = 0;
  double earlier_ = 0; ///< seconds of the search before it was resumed
  std::vector<io::HistoryRow> rows_;
  control::ReducedProblem::Sweeps marked_;
  std::optional<io::Kink> kink_;
  std::ofstream history_; ///< on rank 0
};

} // namespace signorini
