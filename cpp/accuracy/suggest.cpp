// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/grading.h"
#include "accuracy/quantities.h"
#include "accuracy/refinement.h"
#include "accuracy/rung_costs.h"
#include "accuracy/study.h"
#include "accuracy/trials.h"
#include "base/error.h"
#include "scene/spelling.h"
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <utility>

namespace signorini::accuracy {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double least_order = 0.5; ///< of fronts of an impact

/// The cheapest size h and step τ for which both parts of the error add up to `target`. Either changes by a
/// factor of `reach` at most.
Rung proposal(const Trial& from, double target, int dim, const SizeAndStep& orders, double reach) {
  const SizeAndStep factors = cheapest_factors({from.space, from.time}, orders, target, dim, 1 / reach, 2.0);
  Rung next = from.rung;
  next.size = std::stod(fmt::format("{:.2g}", next.size * factors.size));
  return next.with_steps(factors.step);
}

/// The quantity to be accurate: that asked for, or J. Throws UserError.
/// `option`: of the command line, that asks for it.
Quantity the_quantity(const scene::Scene& scene, const std::vector<std::string>& names, int dim,
                      const char* option) {
  std::vector<std::string> allowed;
  for (const Quantity& quantity : quantities(scene, dim))
    if (!quantity.absolute) // whose error is known without
      allowed.push_back(quantity.name);
  if (names.empty() && !scene.objective)
    throw UserError(fmt::format("{}: needs --quantity in a scene without an objective, allowed is one of {}",
                                option, scene::list(allowed)));
  const Quantity found = names.empty() ? Quantity{"J", "J", ""} : chosen(scene, names, dim).front();
  if (names.size() > 1 || found.absolute)
    throw UserError(fmt::format("{}: found --quantity {}, allowed is one of {}", option,
                                fmt::join(names, ","), scene::list(allowed)));
  return found;
}

void require_size(const scene::Scene& scene, const Quantity& quantity, const char* option) {
  if (scene.mesh.meshed())
    throw UserError(fmt::format("{}: found a .msh, which is meshed already, allowed is a .geo", option));
  if (quantity.name == "J" && scene.mesh.degree != 1)
    throw UserError(fmt::format("{}: found mesh.degree = {}, allowed is 1: the estimate in space "
                                "looks at what functions of degree 2 "
                                "have beyond those of degree 1",
                                option, scene.mesh.degree));
}

/// Goes from trial to trial until one meets the tolerance.
class SizeStepSearch {
public:
  using Better = std::function<void(const Trial&, double further)>;

  /// `better` is shown each trial that is better than all before, and the seconds that the tolerance would
  /// take or, where it is met, half the trial's error.
  SizeStepSearch(
      MPI_Comm comm, const scene::Scene& scene, double tolerance, double budget, const Samples& samples,
      const Console& console, Better better = [](const Trial&, double) {})
      : comm_(comm), scene_(scene), tolerance_(tolerance), budget_(budget), samples_(samples),
        console_(console), better_(std::move(better)) {}

  /// The trial that meets it, else the last.
  /// That of degree 2 is tried once, where it costs less than the next step of the search.
  Trial operator()(Trials& trials) const {
    const Rung own = first(trials);
    std::optional<Rung> raised;
    if (trials.any_degree() && own.degree == 1)
      raised = own, raised->degree = 2;
    const RungCosts prices = priced(trials, own, raised);
    Trial last = run(trials, own), nearest = last;
    SizeAndStep orders{trials.order(), trials.order()};
    constexpr double aim =
        0.8; // of the tolerance, so that a little more error than foreseen does not cost another run
    const auto towards = [&](const Trial& from, double error, double reach) {
      return trials.nearest(proposal(from, error, samples_.dim, orders, reach));
    };
    const auto proposed = [&](const Trial& from) { return towards(from, aim * tolerance_, trials.reach()); };
    const auto show = [&](const Trial& trial) {
      constexpr double any_reach = 1e6; // of a rung that is not run
      const double error = trial.error() > tolerance_ ? aim * tolerance_ : trial.error() / 2;
      better_(trial, seconds(trials, towards(trial, error, any_reach), prices));
    };
    show(last);
    if (last.meets(tolerance_) && !economises_)
      return last;
    constexpr int most = 8, most_warned = 3;
    int warned = 0;
    for (int i = 0; i < most; ++i) {
      Rung next = proposed(last);
      if (!last.warning.empty()) {
        if (++warned == most_warned)
          break;
        next = finer(trials, last.rung);
      }
      if (raised && last.error() > tolerance_ &&
          seconds(trials, *raised, prices) < seconds(trials, next, prices))
        next = *std::exchange(raised, std::nullopt);
      if (next == last.rung)
        break;
      if (beyond_budget(trials, next, prices)) {
        const std::optional<Rung> fitting = within_budget(trials, last.rung, next, raised, prices);
        if (!fitting)
          break;
        next = *fitting;
        if (next == raised)
          raised.reset();
      }
      const Trial trial = run(trials, next);
      if (trial.error() < nearest.error() || trial.meets(tolerance_))
        show(trial);
      if (trial.meets(tolerance_))
        return nearest.meets(tolerance_) && nearest.seconds < trial.seconds ? nearest : trial;
      if (trial.error() < nearest.error())
        nearest = trial;
      if (trial.rung.degree == last.rung.degree) {
        orders = {
            observed_order(last.space, trial.space, next.size / last.rung.size, orders.size, least_order),
            observed_order(last.time, trial.time, next.step_width() / last.rung.step_width(), orders.step,
                           least_order)};
      } else if (seconds(trials, proposed(last), prices) < seconds(trials, proposed(trial), prices)) {
        continue;
      }
      last = trial;
    }
    return nearest;
  }

  /// The rung of the first trial: the scene's own size and step, or the nearest that a trial can have.
  [[nodiscard]] Rung first(const Trials& trials) const { return trials.nearest(own_rung(scene_)); }

  /// Ends at the first trial that meets the tolerance, even if a cheaper one would.
  void take_the_first() { economises_ = false; }

  /// Seconds since the search began, the same on all ranks. Collective.
  [[nodiscard]] double passed() const {
    double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    MPI_Bcast(&seconds, 1, MPI_DOUBLE, 0, comm_);
    return seconds;
  }

private:
  /// Tries a rung, and verifies it if its error is small enough.
  [[nodiscard]] Trial run(Trials& trials, const Rung& rung) const {
    Trial trial = trials.run(rung);
    console_.line(fmt::format("{}: {}", words(trial.rung, scene_), trial.said));
    if (trial.error() > tolerance_)
      return trial;
    try {
      trials.verify(trial);
    } catch (const Interrupted&) {
      trial.warning = "no run with half its steps has ended";
      better_(trial, trial.seconds);
      throw;
    }
    console_.line(fmt::format("{}: {}{}", words(trial.rung, scene_), trial.grounds,
                              trial.warning.empty() ? "" : "; not verified: " + trial.warning));
    return trial;
  }

  /// Of what a warning may be cured by.
  [[nodiscard]] static Rung finer(const Trials& trials, Rung rung) {
    constexpr double steps = 0.5, size = 0.7;
    rung.size = std::stod(fmt::format("{:.2g}", size * rung.size));
    return trials.nearest(rung.with_steps(steps));
  }

  /// Of what the search may come to.
  [[nodiscard]] RungCosts priced(const Trials& trials, const Rung& own,
                                 const std::optional<Rung>& raised) const {
    std::vector<Rung> rungs;
    for (const std::optional<Rung>& one : {std::optional(own), raised})
      if (one) {
        rungs.insert(rungs.end(), 2, *one);
        rungs.back().size /= trials.reach();
      }
    return price(comm_, scene_, rungs, samples_, {trials.quantity()}, trials.estimates());
  }

  /// Predicted, of all that has to run for a rung.
  [[nodiscard]] static double seconds(const Trials& trials, const Rung& next, const RungCosts& prices) {
    double sum = 0;
    for (const Rung& rung : trials.runs(next))
      sum += prices.seconds(rung);
    return sum;
  }

  [[nodiscard]] bool beyond_budget(const Trials& trials, const Rung& next, const RungCosts& prices) const {
    const double expected = seconds(trials, next, prices);
    console_.line(fmt::format("next: {}, about {:.2g} s", words(next, scene_), expected));
    const bool beyond = passed() + expected > budget_;
    if (beyond)
      console_.line(fmt::format("that is beyond the budget of {:.3g} s (--budget)", budget_));
    return beyond;
  }

  /// Where `next` is not: degree 2 at the size that it was priced for, or a part of the way from `last`;
  /// absent if that is little.
  [[nodiscard]] std::optional<Rung> within_budget(const Trials& trials, const Rung& last, const Rung& next,
                                                  const std::optional<Rung>& raised,
                                                  const RungCosts& prices) const {
    constexpr double worth = 0.9; // the least change of a size or a step
    std::vector<Rung> others;
    if (raised)
      others.push_back(*raised);
    for (const double part : {0.75, 0.5, 0.25}) {
      const double wider = std::pow(next.size / last.size, part),
                   longer = std::pow(next.step_width() / last.step_width(), part);
      Rung between = next;
      between.size = std::stod(fmt::format("{:.2g}", last.size * wider));
      if (std::min(wider, longer) < worth)
        others.push_back(trials.nearest(between.with_steps(longer * last.step_width() / next.step_width())));
    }
    const double left = budget_ - passed();
    for (const Rung& rung : others)
      if (seconds(trials, rung, prices) <= left) {
        console_.line(
            fmt::format("instead: {}, about {:.2g} s", words(rung, scene_), seconds(trials, rung, prices)));
        return rung;
      }
    return std::nullopt;
  }

  MPI_Comm comm_;
  const scene::Scene& scene_;
  double tolerance_;
  double budget_;
  const Samples& samples_;
  const Console& console_;
  Better better_;
  bool economises_ = true;
  Clock::time_point start_ = Clock::now();
};

} // namespace

int suggest(MPI_Comm comm, const scene::Scene& scene, double tolerance, const Options& options,
            const Console& console) {
  constexpr const char* option = "--suggest";
  require_size(scene, the_quantity(scene, options.quantities, 2, option), option);
  require_answer(comm, scene);
  const Samples samples(comm, scene);
  const Quantity quantity = the_quantity(scene, options.quantities, samples.dim, option);
  const std::unique_ptr<Trials> trials = quantity.name == "J" ? adjoint_trials(comm, scene, samples)
                                                              : ladder_trials(comm, scene, samples, quantity);
  constexpr double usual_budget = 600; // s, as --help says
  const SizeStepSearch search(comm, scene, tolerance, options.budget.value_or(usual_budget), samples,
                              console);
  const Trial found = search(*trials);
  const bool met = found.meets(tolerance);
  console.line(fmt::format("{:g} in {} is {}: {}, {}, {:.2g} s; found in {:.2g} s", tolerance, quantity.title,
                           met                     ? "met by"
                           : found.warning.empty() ? "not met; the nearest is"
                                                   : "not verified (" + found.warning + "); the nearest is",
                           words(found.rung, scene), found.grounds, found.seconds, search.passed()));
  return met ? 0 : 1;
}

BestRun find_size_and_step(MPI_Comm comm, const scene::Scene& scene, double tolerance, const Options& options,
                           const Console& console, const std::function<void(const BestRun&)>& better) {
  scene::Scene simulated = scene; // under the control that is given, whatever an objective desires
  simulated.objective.reset();
  constexpr const char* option = "--accuracy";
  const auto quantity_of = [&](int dim) { return the_quantity(simulated, options.quantities, dim, option); };
  require_size(simulated, quantity_of(2), option);
  require_answer(comm, simulated);
  const Samples samples(comm, simulated);
  const std::unique_ptr<Trials> trials = ladder_trials(comm, simulated, samples, quantity_of(samples.dim));
  BestRun best;
  SizeStepSearch search(comm, simulated, tolerance,
                        options.budget.value_or(std::numeric_limits<double>::infinity()), samples, console,
                        [&](const Trial& trial, double further) {
                          best = {trial.rung, trial.space, trial.time, trial.seconds, further, trial.warning};
                          better(best);
                        });
  search.take_the_first();
  // An answer early, though of an error that nothing tells yet.
  best = {.rung = trials->runs(search.first(*trials)).front(), .space = 1, .time = 1};
  better(best);
  (void)search(*trials);
  return best;
}

} // namespace signorini::accuracy
