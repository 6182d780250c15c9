// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/reduced_problem.h"
#include "drivers/resume.h"
#include "io/csv_tables.h"
#include "io/manifest.h"
#include "io/output_folder.h"
#include "optimize/minimize.h"
#include "optimize/report.h"
#include "problem/parameter_problem.h"
#include <chrono>
#include <fstream>

namespace signorini::drivers {

/// Describes a kink by its certificate and its weak contact: the candidates, step by step, that are active at
/// some points of the certificate and open at others. Makes a forward sweep for each point, which is not
/// counted in reduced.sweeps(). Throws Interrupted. Collective.
[[nodiscard]] io::Kink describe(control::ReducedProblem& reduced,
                                const optimize::Certificate<control::Variables>& certificate);

/// Converts a kink to the numbers that a checkpoint stores.
[[nodiscard]] std::vector<double> numbers(const io::Kink& kink);

/// Restores a kink from the result of numbers(), in `dim` dimensions; absent if the numbers are invalid.
[[nodiscard]] std::optional<io::Kink> kink_of(const std::vector<double>& numbers, int dim);

/// Problem of a search for a control, for parameters of a scene, or for both.
struct SearchSubject {
  const scene::Scene& scene; ///< scene as written into the results
  const problem::SpaceDiscretisation& discretisation;
  control::ReducedProblem& reduced;
  Timers& timers;
  const problem::Problem* problem = nullptr;             ///< set if a control is sought; has the time grid
  const problem::ControlProblem* control = nullptr;      ///< set if a control is sought
  const problem::ParameterProblem* parameters = nullptr; ///< set if parameters are sought

  [[nodiscard]] MPI_Comm comm() const { return discretisation.space.comm(); }
  [[nodiscard]] std::size_t parameter_count() const {
    return parameters ? parameters->scene.unknowns.size() : 0;
  }
};

/// Writes the output of a search while it runs: progress on the console, a row of history.csv for each
/// iterate, and checkpoint.h5. Serves as `report` and `checkpointer` of optimize::minimize(). All members are
/// collective.
class SearchLog {
public:
  /// `solver`: name of the checkpoint's entry for the linear solver of the steps. `iterative`: value of this
  /// entry for conjugate gradients.
  static constexpr const char *solver = "solver", *iterative = "iterative";
  static constexpr const char* levels = "levels"; ///< name of the checkpoint's entry for varying step lengths

  /// Time at which history.csv appears in the output folder: during the search, or with its results.
  enum class Files { early, with_results };

  /// Prepares the output. `resume`: whether to continue from the folder's checkpoint, if it has one. The
  /// references must outlive this object.
  SearchLog(const SearchSubject& subject, const io::OutputFolder& folder, bool resume, const Console& console,
            Files files = Files::early);

  /// Records an iterate of a search with a control; the reduced problem must be at the iterate.
  void operator()(const optimize::Iteration& iteration);
  /// Records an iterate of a fit without a control.
  void operator()(const optimize::GaussNewtonIterate& iterate);

  /// Whether the search continues from a checkpoint.
  [[nodiscard]] bool resumes() const { return resumes_; }

  /// Restores the state of the search from the checkpoint; returns false if the search does not resume.
  /// Throws UserError if the checkpoint is damaged or belongs to another problem.
  template <class State>
  bool restore(State& state) {
    if (!resumes_)
      return false;
    io::CheckpointReader in = subject_.control ? io::CheckpointReader(subject_.control->controls, file_)
                                               : io::CheckpointReader(subject_.comm(), file_);
    read(in);
    control::VariablesArchive archive(in, subject_.parameter_count());
    state.serialize(archive);
    return true;
  }

  /// Continues the log of a restored search. Throws UserError if J in the checkpoint, `stored`, and J
  /// recomputed at the same point, `found`, differ by more than a change of the number of ranks explains.
  void restored(double stored, double found);

  /// Whether a checkpoint is to be written after this iteration.
  [[nodiscard]] bool due(const optimize::Iteration& iteration) const {
    return every_ > 0 && iteration.number % every_ == 0 && iteration.number != stored_at_;
  }

  /// Notes the current counts of sweeps; checkpoints contain these counts until the next call.
  void mark() { marked_ = subject_.reduced.sweeps(); }

  /// Records the kink at which the search ends. Throws Interrupted.
  void certified(const optimize::Certificate<control::Variables>& certificate) {
    kink_ = describe(subject_.reduced, certificate);
  }
  /// Kink at which the search ended, now or before it was resumed; absent if it did not end at a kink.
  [[nodiscard]] const std::optional<io::Kink>& final_kink() const { return kink_; }

  /// Writes a checkpoint. If that fails, prints a message; the previous checkpoint stays.
  template <class State>
  void store(State& state) {
    if (every_ == 0 || history_.rows() == 0)
      return;
    const auto timer = subject_.timers.time("checkpoint");
    const std::filesystem::path part = folder_.staged(resume::checkpoint);
    io::CheckpointWriter out = subject_.control
                                   ? io::CheckpointWriter(subject_.control->controls, part, file_)
                                   : io::CheckpointWriter(subject_.comm(), part, file_);
    write(out);
    control::VariablesArchive archive(out, subject_.parameter_count());
    state.serialize(archive);
    stored_at_ = state.iteration.number;
    if (const std::string failure = out.commit(); !failure.empty())
      console_.line(resume::not_written(file_, failure));
  }

  [[nodiscard]] const SearchSubject& subject() const { return subject_; }

  /// Ends the display of progress.
  void end() { progress_.reset(); }

  /// History of the whole search, including iterations before the search was resumed.
  [[nodiscard]] const io::History& history() const { return history_; }
  /// Seconds of the whole search, including the time before the search was resumed.
  [[nodiscard]] double seconds() const;

  /// Whether J has been evaluated in this process, at the first guess or at the checkpoint's point.
  [[nodiscard]] bool evaluated() const { return evaluated_; }

private:
  using Clock = std::chrono::steady_clock;

  void read(io::CheckpointReader& in);
  void write(io::CheckpointWriter& out) const;
  /// Text of the resolved scene.
  [[nodiscard]] std::string echoed() const;
  /// Adds a row to the history, completed by the parameter values θ at x; returns θ.
  std::vector<double> add(io::History::Row row, std::span<const double> x);
  /// Creates history.csv with all rows, or appends the last row to it.
  void show_row();

  SearchSubject subject_;
  const io::OutputFolder& folder_;
  const Console& console_;
  std::filesystem::path file_;
  Files files_;
  int every_, stored_at_ = -1;
  bool resumes_, evaluated_ = false;
  std::optional<Progress> progress_; ///< set if only a control is sought; else each iterate prints a line
  Clock::time_point start_ = Clock::now();
  double reference_norm_ = 0;
  double earlier_ = 0; ///< seconds of the search before it was resumed
  io::History history_;
  control::ReducedProblem::Sweeps marked_;
  std::optional<io::Kink> kink_;
  std::ofstream table_; ///< history.csv, on rank 0
};

} // namespace signorini::drivers
