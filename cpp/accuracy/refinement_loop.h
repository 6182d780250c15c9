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

/// The order with which a part of the error has fallen from `coarse` to `fine` as its width changed by
/// `factor` < 1, between that of fronts of an impact and above that of the schemes; `otherwise` where these
/// determine none.
double observed_order(double coarse, double fine, double factor, double otherwise);

/// Factors of size and step for which the parts of an error, proportional to powers of them with `orders`,
/// add up to `target` at the least cost, which grows as size^(−dim·step_power(dim)) / step; each between
/// `least` and `most`. Where nothing may become coarser, a part that is small already leaves its share to the
/// other.
SizeAndStep cheapest_factors(const SizeAndStep& error, const SizeAndStep& orders, double target, int dim,
                             double least, double most);

/// A run at one size and one step, and the estimated parts of its relative error.
struct TrialRun {
  Rung rung;
  double space = 0, time = 0;
  double search = 0;     ///< what a search has left to gain
  double seconds = 0;    ///< of the run alone
  std::string grounds{}; ///< how the error was found
  std::string warning{}; ///< why the run is not verified though its error is small
  [[nodiscard]] double error() const { return space + time + search; }
  [[nodiscard]] bool meets(double tolerance) const { return error() <= tolerance && warning.empty(); }
};

/// Makes runs of a scene at given sizes and steps, estimates their errors and keeps their results. All
/// members are collective; those that run throw UserError, SolverFailure, Interrupted.
class TrialRuns {
public:
  /// Bounds of what an estimate predicts.
  struct Reach {
    double order;   ///< with which estimates fall, before any is observed
    double finer;   ///< the largest factor by which size and step become smaller at once
    double coarser; ///< and larger
  };

  virtual ~TrialRuns() = default;
  [[nodiscard]] virtual Reach reach() const = 0;
  [[nodiscard]] virtual int dim() const = 0;
  /// Title of the quantity whose error is estimated.
  [[nodiscard]] virtual std::string title() const { return "J"; }
  /// The first rungs, of which the first that can be meshed and solved is taken.
  [[nodiscard]] virtual std::vector<Rung> beginnings() const = 0;
  /// A coarse rung whose results are kept before any error is estimated.
  [[nodiscard]] virtual std::optional<Rung> unestimated() const { return {}; }
  /// The next finer rung that can run.
  [[nodiscard]] virtual Rung nearest(const Rung& rung) const = 0;
  /// A rung of another degree that is tried once, where it costs less than the next step of the refinement.
  [[nodiscard]] virtual std::optional<Rung> other_degree() const { return {}; }
  /// Predicted seconds of all that runs for a rung.
  [[nodiscard]] virtual double seconds(const Rung& rung) = 0;
  /// Size and step in words.
  [[nodiscard]] virtual std::string words(const Rung& rung) const = 0;

  virtual TrialRun run(const Rung& rung) = 0;
  /// Compares the last run with half its steps, by which its error in time may turn out to be larger, and
  /// sets its warning.
  virtual void verify(TrialRun& trial) = 0;
  /// Ends the last run; its results are kept if it is `better` than all before.
  virtual void conclude(const TrialRun& trial, bool better) = 0;
};

/// The refinement of size and step from run to run: to the cheapest for which the predicted error adds up to
/// the tolerance. The references must outlive this object.
class Refinement {
public:
  /// `tolerance`: of the estimated error. `budget`: a run is not begun if it is predicted to exceed it, s.
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
  /// Why no further run follows, though the tolerance is not met.
  [[nodiscard]] const std::string& ended() const { return ended_; }
  /// Predicted seconds of what the tolerance takes or, where within(), half of best()'s error.
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

/// What is asked of an answer.
struct AccuracyAsked {
  double error;                             ///< relative, of the quantity
  std::optional<double> budget{};           ///< s
  std::vector<std::string> quantities{"J"}; ///< names, of which there has to be one
};

/// Runs a refinement for --accuracy, which stop_after() may end, and reports with a sentence of what was
/// asked, what is estimated, what it took, and what half the error would take. Returns the exit status: 1 if
/// the error is not met, 130 if interrupted. Collective. Throws UserError, SolverFailure, and Interrupted
/// before there is an answer.
int refine_to_accuracy(MPI_Comm comm, Refinement& refinement, const TrialRuns& trials,
                       const AccuracyAsked& asked, const std::filesystem::path& out, const Console& console);

} // namespace signorini::accuracy
