#pragma once
#include "io/checkpoint.h"
#include "io/output_folder.h"
#include "io/tables.h"
#include "optimize/search.h"
#include "problem.h"
#include <fstream>

namespace signorini {

/// What is known of a search while it goes on: progress, history.csv in the folder, a line for each iteration
/// as soon as it is made, and checkpoint.h5. All members collective.
class SearchRecord {
public:
  static constexpr const char* checkpoint = "checkpoint.h5"; ///< the file's name

  /// With `resume` the search goes on from the folder's checkpoint, where it has one. The references must
  /// outlive this object.
  SearchRecord(ControlProblem& control_problem, const Problem& problem, const io::OutputFolder& folder,
               bool resume, const Console& console);

  /// Takes an iterate, the problem's current point.
  void operator()(const optimize::Iteration& iteration);

  /// Reads where the search stood; false if there is no checkpoint. Throws UserError if it is damaged or of
  /// another problem.
  template <class State>
  bool restore(State& state) {
    if (!resume_ || !found())
      return false;
    io::CheckpointReader in(control_problem_.controls, file_);
    read(in);
    state.exchange(in);
    return true;
  }

  /// Takes J as it was when the checkpoint was written and as it is now. Throws UserError if they differ by
  /// more than other ranks explain.
  void restored(double stored, double found);

  [[nodiscard]] bool due(const optimize::Iteration& iteration) const {
    return every_ > 0 && iteration.number % every_ == 0 && iteration.number != stored_at_;
  }

  /// Writes where it stands. A failure is said and the search goes on: the last checkpoint stays.
  template <class State>
  void store(State& state) {
    if (every_ == 0 || rows_.empty())
      return;
    const auto timer = problem_.timers.time("checkpoint");
    io::CheckpointWriter out(control_problem_.controls, folder_.staged(checkpoint), file_);
    write(out);
    state.exchange(out);
    stored_at_ = state.iteration.number;
    if (const std::string failure = out.commit(); !failure.empty())
      console_.line(not_written(failure));
  }

  /// Ends the display of progress.
  void end() { progress_.reset(); }

  /// Of the whole search, those before it was resumed included.
  [[nodiscard]] const std::vector<io::HistoryRow>& rows() const { return rows_; }

  /// Whether the problem's current point is one of the search's: J was evaluated at the first guess, or where the
  /// checkpoint said that it stood.
  [[nodiscard]] bool evaluated() const { return evaluated_; }

private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] bool found() const;
  void read(io::CheckpointReader& in);
  void write(io::CheckpointWriter& out) const;
  /// Starts history.csv with the rows so far, or adds the last one.
  void show_row();
  [[nodiscard]] double seconds() const;
  [[nodiscard]] std::string not_written(const std::string& failure) const;

  ControlProblem& control_problem_;
  const Problem& problem_;
  const io::OutputFolder& folder_;
  const Console& console_;
  std::filesystem::path file_;
  int every_, stored_at_ = -1;
  bool resume_, evaluated_ = false;
  std::optional<Progress> progress_;
  Clock::time_point start_ = Clock::now();
  double earlier_ = 0; ///< seconds of the search before it was resumed
  std::vector<io::HistoryRow> rows_;
  std::ofstream history_; ///< on rank 0
};

} // namespace signorini
