// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/rungs.h"
#include "base/collective.h"
#include "base/progress.h"
#include <filesystem>
#include <mpi.h>
#include <optional>

/// The multilevel loop: sizes and steps are refined until a run meets a relative error.
namespace signorini::accuracy {

/// A pair of numbers: one for the size of elements, one for the length of steps.
struct SizeAndStep {
  double size = 0, step = 0;
};

/// Observed order of a part of the error that fell from `coarse` to `fine` as the element size or the step
/// fell by `factor`, clamped between that at wave fronts of an impact and a little above that of the schemes;
/// `otherwise` where the values give none.
double observed_order(double coarse, double fine, double factor, double otherwise);

/// Factors of size and step at which the parts of an error add up to `target` at the least cost. The parts
/// are proportional to powers of the factors with `orders`, the cost is size^(−dim·step_power(dim)) / step;
/// each factor is between `least` and `most`. Where nothing may become coarser, a part that is small already
/// leaves its share to the other.
SizeAndStep cheapest_factors(const SizeAndStep& error, const SizeAndStep& orders, double target, int dim,
                             double least, double most);

/// A run at one size and one step, and the estimated parts of its relative error.
struct TrialRun {
  Rung rung;
  double space = 0, time = 0;
  double search = 0;     ///< decrease of J that the search leaves
  double seconds = 0;    ///< duration of the run alone
  std::string grounds{}; ///< source of the error, in words
  std::string warning{}; ///< why the run is not verified though its error is small
  [[nodiscard]] double error() const { return space + time + search; }
  [[nodiscard]] bool meets(double tolerance) const { return error() <= tolerance && warning.empty(); }
};

/// Makes runs of a scene at given sizes and steps, estimates their errors and keeps their results. All
/// members are collective; those that run throw UserError, SolverFailure, Interrupted.
class TrialRuns {
public:
  /// Range in which estimates predict the error of other sizes and steps.
  struct Reach {
    double order;   ///< assumed order of the estimates, before any is observed
    double finer;   ///< the largest factor by which size and step become smaller at once
    double coarser; ///< the largest factor by which they become larger at once
  };

  virtual ~TrialRuns() = default;
  [[nodiscard]] virtual Reach reach() const = 0;
  [[nodiscard]] virtual int dim() const = 0;
  /// Title of the quantity whose error is estimated.
  [[nodiscard]] virtual std::string title() const { return "J"; }
  /// Rungs to begin with; the first that can be meshed and solved is taken.
  [[nodiscard]] virtual std::vector<Rung> beginnings() const = 0;
  /// A coarse rung whose results are kept before any error is estimated.
  [[nodiscard]] virtual std::optional<Rung> unestimated() const { return {}; }
  /// The next finer rung that can run.
  [[nodiscard]] virtual Rung nearest(const Rung& rung) const = 0;
  /// A rung of another degree that is tried once, where it costs less than the next step of the refinement.
  [[nodiscard]] virtual std::optional<Rung> other_degree() const { return {}; }
  /// Predicted seconds of all runs that a rung needs.
  [[nodiscard]] virtual double seconds(const Rung& rung) = 0;
  /// Size and step in words.
  [[nodiscard]] virtual std::string words(const Rung& rung) const = 0;

  virtual TrialRun run(const Rung& rung) = 0;
  /// Compares the last run with one of half the step length, which may raise its error in time, and sets its
  /// warning.
  virtual void verify(TrialRun& trial) = 0;
  /// Ends the last run; its results are kept if it is `better` than all before.
  virtual void conclude(const TrialRun& trial, bool better) = 0;
};

/// Refines size and step from run to run, to the cheapest for which the predicted error meets the tolerance.
/// The references must outlive this object.
class Refinement {
public:
  /// `tolerance`: limit of the estimated error. `budget`, s: a run is not begun if it is predicted to exceed
  /// it.
  Refinement(TrialRuns& trials, double tolerance, std::optional<double> budget, const Elapsed& elapsed,
             const Console& console)
      : trials_(trials), tolerance_(tolerance), budget_(budget), elapsed_(elapsed), console_(console),
        orders_{trials.reach().order, trials.reach().order} {}

  /// Refines until a run meets the tolerance or none can follow. With `economise` a first run that meets it
  /// is followed by cheaper ones. Throws UserError, SolverFailure, Interrupted. Collective.
  void run(bool economise);

  /// The run with the smallest error so far, or the cheapest of those that meet the tolerance; its results
  /// are kept.
  [[nodiscard]] const std::optional<TrialRun>& best() const { return best_; }
  [[nodiscard]] bool met() const { return best_ && best_->meets(tolerance_); }
  /// Whether the error of best() is small enough, verified or not.
  [[nodiscard]] bool within() const { return best_ && best_->error() <= tolerance_; }
  /// Reason why no further run follows, though the tolerance is not met; empty if there is none.
  [[nodiscard]] const std::string& ended() const { return ended_; }
  /// Predicted seconds of a run that meets the tolerance or, where within(), has half of best()'s error.
  [[nodiscard]] double further() const { return further_; }
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
  std::optional<TrialRun> best_;
  std::string ended_;
  double further_ = 0;
};

/// Accuracy, budget and quantity that the command line requests.
struct AccuracyAsked {
  double error;                             ///< relative, of the quantity
  std::optional<double> budget{};           ///< s
  std::vector<std::string> quantities{"J"}; ///< names, exactly one
};

/// Runs a refinement for --accuracy, which stop_after() may end. Prints a sentence with the requested and the
/// estimated error, the time taken, and the time that half the error would take. Returns the exit status: 1
/// if the error is not met, 130 if interrupted. Collective. Throws UserError, SolverFailure, and Interrupted
/// before there is an answer.
int refine_to_accuracy(MPI_Comm comm, Refinement& refinement, const TrialRuns& trials,
                       const AccuracyAsked& asked, const std::filesystem::path& out, const Console& console);

} // namespace signorini::accuracy
