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

/// Describes a kink by its certificate and the weak contact there: the candidates, by step, that are active
/// at some of its points and open at others. Makes a forward sweep for each point, which is not counted.
/// Throws Interrupted. Collective.
[[nodiscard]] io::Kink describe(control::ReducedProblem& reduced,
                                const optimize::Certificate<control::Variables>& certificate);

/// Converts a kink to the numbers that a checkpoint stores.
[[nodiscard]] std::vector<double> numbers(const io::Kink& kink);

/// Restores a kink from numbers(), in `dim` dimensions; none if they are invalid.
[[nodiscard]] std::optional<io::Kink> kink_of(const std::vector<double>& numbers, int dim);

/// Problem of a search for a control, for the parameters of a scene, or for both. Null parts are absent.
struct SearchSubject {
  const scene::Scene& scene; ///< scene as written into the results
  const problem::Discretisation& discretisation;
  control::ReducedProblem& reduced;
  Timers& timers;
  const problem::Problem* problem = nullptr; ///< defines the steps of a control
  const problem::ControlProblem* control = nullptr;
  const problem::ParameterProblem* parameters = nullptr;

  [[nodiscard]] MPI_Comm comm() const { return discretisation.space.comm(); }
  [[nodiscard]] std::size_t parameter_count() const {
    return parameters ? parameters->scene.unknowns.size() : 0;
  }
};

/// Output of a search while it runs: progress, history.csv in the folder, with a row as soon as there is an
/// iterate, and checkpoint.h5. Serves as `report` and `checkpointer` of optimize::minimize(). All members
/// collective.
class SearchLog {
public:
  /// The checkpoint's entry for the solver of the steps, and its value for conjugate gradients.
  static constexpr const char *solver = "solver", *iterative = "iterative";
  static constexpr const char* levels = "levels"; ///< the checkpoint's entry for step lengths, if they vary

  /// Time at which files are put in place: while the search runs, or with its results.
  enum class Files { early, with_results };

  /// Prepares the output. With `resume` the search continues from the folder's checkpoint, if there is one.
  /// The references must outlive this object.
  SearchLog(const SearchSubject& subject, const io::OutputFolder& folder, bool resume, const Console& console,
            Files files = Files::early);

  /// Records an iterate, the reduced problem's current point.
  void operator()(const optimize::Iteration& iteration);
  /// Records an iterate of a fit.
  void operator()(const optimize::GaussNewtonIterate& iterate);

  /// Whether the search continues from a checkpoint.
  [[nodiscard]] bool resumes() const { return resumes_; }

  /// Restores the state of the search; false if there is no checkpoint. Throws UserError if it is damaged or
  /// of another problem.
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

  /// Compares J as stored in the checkpoint with J as evaluated now. Throws UserError if they differ by more
  /// than another number of ranks explains.
  void restored(double stored, double found);

  /// Whether a checkpoint is to be written after this iteration.
  [[nodiscard]] bool due(const optimize::Iteration& iteration) const {
    return every_ > 0 && iteration.number % every_ == 0 && iteration.number != stored_at_;
  }

  /// Stores the counts of sweeps that checkpoints contain until the next mark.
  void mark() { marked_ = subject_.reduced.sweeps(); }

  /// Describes the kink at which the search ends. Throws Interrupted.
  void certified(const optimize::Certificate<control::Variables>& certificate) {
    kink_ = describe(subject_.reduced, certificate);
  }
  /// The kink, if there was a certificate here or in the checkpoint.
  [[nodiscard]] const std::optional<io::Kink>& kink() const { return kink_; }

  /// Writes a checkpoint. A failure is reported and the search continues: the last checkpoint stays.
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

  /// History of the whole search, with the iterations before it was resumed.
  [[nodiscard]] const io::History& history() const { return history_; }
  /// Seconds of the whole search.
  [[nodiscard]] double seconds() const;

  /// Whether J was evaluated at the first guess, or at the checkpoint's point.
  [[nodiscard]] bool evaluated() const { return evaluated_; }

private:
  using Clock = std::chrono::steady_clock;

  void read(io::CheckpointReader& in);
  void write(io::CheckpointWriter& out) const;
  /// The scene as text.
  [[nodiscard]] std::string echoed() const;
  /// Adds a row with the parameters at x; returns θ.
  std::vector<double> add(io::History::Row row, std::span<const double> x);
  /// Starts history.csv with the rows so far, or adds the last one.
  void show_row();

  SearchSubject subject_;
  const io::OutputFolder& folder_;
  const Console& console_;
  std::filesystem::path file_;
  Files files_;
  int every_, stored_at_ = -1;
  bool resumes_, evaluated_ = false;
  std::optional<Progress> progress_; ///< only for a control alone; others print a line for each iterate
  Clock::time_point start_ = Clock::now();
  double reference_norm_ = 0;
  double earlier_ = 0; ///< seconds of the search before it was resumed
  io::History history_;
  control::ReducedProblem::Sweeps marked_;
  std::optional<io::Kink> kink_;
  std::ofstream table_; ///< history.csv, on rank 0
};

} // namespace signorini::drivers
