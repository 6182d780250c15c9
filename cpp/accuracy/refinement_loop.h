// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/rungs.h"
#include "base/collective.h"
#include "base/progress.h"
#include <filesystem>
#include <mpi.h>
#include <optional>

/// Refinement of element sizes and time steps until a run meets a relative error.
namespace signorini::accuracy {

/// A pair of numbers: one for the element size, one for the length of steps.
struct SizeAndStep {
  double size = 0, step = 0;
};

/// Observed order of an error that changed from `coarse` to `fine` when the element size or step was
/// multiplied by `factor`. The order is clamped to the range from 0.5 (wave fronts of an impact) to 2.5
/// (slightly above the order of the schemes). Returns `otherwise` unless the factor is below 0.9 and both
/// errors are positive.
double observed_order(double coarse, double fine, double factor, double otherwise);

/// Factors on size and step with which the parts of `error` add up to `target` at the least cost. The parts
/// are proportional to powers of the factors with the exponents `orders`; the cost is proportional to
/// size^(−dim·step_power(dim)) / step. Each factor is between `least` and `most`. If `most` is at most 1,
/// size and step cannot grow: a part that is already below its optimal share of the target keeps its value,
/// and the other part gets the rest of the target.
SizeAndStep cheapest_factors(const SizeAndStep& error, const SizeAndStep& orders, double target, int dim,
                             double least, double most);

/// Warning of a run whose J cannot be compared with that of a coarser mesh.
inline constexpr const char* no_coarser_mesh = "no coarser mesh to compare J with";

/// A run on one rung, and the estimated parts of its relative error.
struct TrialRun {
  Rung rung;
  double space = 0, time = 0; ///< relative errors due to the mesh and due to the time steps
  double search = 0;          ///< relative error of the search: the decrease of J that remains
  double seconds = 0;         ///< duration of this run
  std::string grounds{};      ///< how the error was estimated, in words
  std::string warning{};      ///< why an error within the tolerance counts as not verified, else empty
  /// Estimated relative error: the sum of its parts.
  [[nodiscard]] double error() const { return space + time + search; }
  /// Whether the error is at most `tolerance`, without a warning.
  [[nodiscard]] bool meets(double tolerance) const { return error() <= tolerance && warning.empty(); }
};

/// Interface of classes that run a scene on given rungs, estimate the errors and store the results. All
/// members are collective; run() and verify() throw UserError, SolverFailure, Interrupted.
class TrialRuns {
public:
  /// Range in which an error estimate predicts the errors of other rungs.
  struct Reach {
    double order;   ///< assumed order of convergence before an order has been observed
    double finer;   ///< largest factor by which size and step may decrease from one run to the next
    double coarser; ///< largest factor by which size and step may increase from one run to the next
  };

  virtual ~TrialRuns() = default;
  /// Range in which predictions are used.
  [[nodiscard]] virtual Reach reach() const = 0;
  /// Dimension of the mesh.
  [[nodiscard]] virtual int dim() const = 0;
  /// Title of the quantity whose error is estimated.
  [[nodiscard]] virtual std::string title() const { return "J"; }
  /// Rungs for the first run; the first rung that can be meshed and solved is used.
  [[nodiscard]] virtual std::vector<Rung> first_rungs() const = 0;
  /// Coarse rung whose results are stored first, before any error is estimated; absent if there is none.
  [[nodiscard]] virtual std::optional<Rung> preliminary_rung() const { return {}; }
  /// Returns `rung` or, if that cannot be run and estimated, the nearest rung that can. Its steps are never
  /// longer than those of `rung`.
  [[nodiscard]] virtual Rung nearest(const Rung& rung) const = 0;
  /// Rung of another degree, which is tried once if it costs less than the next refinement; absent if there
  /// is none.
  [[nodiscard]] virtual std::optional<Rung> first_rung_of_other_degree() const { return {}; }
  /// Predicted seconds of all runs that are needed to run and estimate a rung.
  [[nodiscard]] virtual double seconds(const Rung& rung) = 0;
  /// Describes size and step of a rung.
  [[nodiscard]] virtual std::string words(const Rung& rung) const = 0;

  /// Runs a rung and estimates its error.
  virtual TrialRun run(const Rung& rung) = 0;
  /// Compares the last run, `trial`, with a run with half the step length. Sets the warning of `trial`.
  /// Raises its error in time if the comparison yields a larger one.
  virtual void verify(TrialRun& trial) = 0;
  /// Ends the last run, and stores its results if `better`, that is, if it is better than all runs before.
  virtual void conclude(const TrialRun& trial, bool better) = 0;
};

/// Refines size and step from run to run. Each next run is the cheapest one whose predicted error meets the
/// tolerance. The references must outlive this object.
class Refinement {
public:
  /// `tolerance`: limit of the estimated relative error. `budget`: time limit, s; a run does not start if it
  /// is predicted to end later. `elapsed`: time since the start of the refinement.
  Refinement(TrialRuns& trials, double tolerance, std::optional<double> budget, const Elapsed& elapsed,
             const Console& console)
      : trials_(trials), tolerance_(tolerance), budget_(budget), elapsed_(elapsed), console_(console),
        orders_{trials.reach().order, trials.reach().order} {}

  /// Refines until a run meets the tolerance or no further run is possible. `economise`: whether to try a
  /// cheaper run if the first one meets the tolerance. Throws UserError, SolverFailure, Interrupted.
  /// Collective.
  void run(bool economise);

  /// The best run so far, whose results are stored: the cheapest run that meets the tolerance, else the run
  /// with the smallest error. Absent before the first run.
  [[nodiscard]] const std::optional<TrialRun>& best() const { return best_; }
  /// Whether best() meets the tolerance without a warning.
  [[nodiscard]] bool met() const { return best_ && best_->meets(tolerance_); }
  /// Whether the estimated error of best() is within the tolerance, with or without a warning.
  [[nodiscard]] bool within() const { return best_ && best_->error() <= tolerance_; }
  /// Reason why the refinement ended before the tolerance was met; may be empty.
  [[nodiscard]] const std::string& stop_reason() const { return stop_reason_; }
  /// Predicted seconds of a run that meets the tolerance. If best() is already within the tolerance, it is a
  /// run with half the error of best().
  [[nodiscard]] double seconds_to_next_goal() const;
  /// Seconds since the start of the refinement.
  [[nodiscard]] double seconds() const { return elapsed_.seconds(); }

private:
  TrialRun begin();
  TrialRun tried(const Rung& rung);
  [[nodiscard]] Rung towards(const TrialRun& from, double error, double reach) const;
  [[nodiscard]] Rung proposed(const TrialRun& from) const;
  [[nodiscard]] std::optional<Rung> following(const TrialRun& last, std::optional<Rung>& other_degree);
  [[nodiscard]] std::optional<Rung> within_budget(const Rung& last, const Rung& next,
                                                  const std::optional<Rung>& other_degree);

  TrialRuns& trials_;
  double tolerance_;
  std::optional<double> budget_;
  const Elapsed& elapsed_;
  const Console& console_;
  SizeAndStep orders_;
  std::optional<TrialRun> best_, latest_;
  std::string stop_reason_;
};

/// Accuracy, budget and quantity that the command line requests.
struct AccuracyAsked {
  double error;                             ///< relative error of the quantity
  std::optional<double> budget{};           ///< time limit, s
  std::vector<std::string> quantities{"J"}; ///< name of the quantity; exactly one
};

/// Runs a refinement for --accuracy, until the requested error is met or a time limit set by stop_after()
/// passes. Prints a sentence with the requested and the estimated error, the time taken, and the predicted
/// time for a smaller error. Returns the exit status: 1 if the error is not met, 130 if interrupted. Throws
/// UserError, SolverFailure. Throws Interrupted if it is interrupted before the first result. Collective.
int refine_to_accuracy(MPI_Comm comm, Refinement& refinement, const TrialRuns& trials,
                       const AccuracyAsked& asked, const std::filesystem::path& out, const Console& console);

} // namespace signorini::accuracy
