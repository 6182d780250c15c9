// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/refinement_loop.h"
#include "base/error.h"
#include "base/signals.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace signorini::accuracy {
namespace {

/// Error aimed at, relative to the tolerance. Below 1, so that an error slightly larger than predicted does
/// not cost another run.
constexpr double aim = 0.8;
constexpr int most_runs = 20;
/// Number of runs with a warning after which the refinement ends.
constexpr int most_warned = 3;

double two_digits(double size) { return std::stod(fmt::format("{:.2g}", size)); }

Rung scaled(Rung rung, const SizeAndStep& factors) {
  rung.size = two_digits(rung.size * factors.size);
  return rung.with_steps(factors.step);
}

} // namespace

double observed_order(double coarse, double fine, double factor, double otherwise) {
  constexpr double least = 0.5, most = 2.5, enough = 0.9;
  if (!(factor < enough) || !(coarse > 0) || !(fine > 0))
    return otherwise;
  return std::clamp(std::log(fine / coarse) / std::log(factor), least, most);
}

SizeAndStep cheapest_factors(const SizeAndStep& error, const SizeAndStep& orders, double target, int dim,
                             double least, double most) {
  // At the minimum the parts are in proportion to the exponents of the cost over their orders.
  const double of_size = dim * step_power(dim) / orders.size, of_step = 1 / orders.step;
  double size = target * of_size / (of_size + of_step), step = target - size;
  if (most <= 1) {
    if (error.step < step && error.size > size)
      size = target - error.step;
    else if (error.size < size && error.step > step)
      step = target - error.size;
  }
  const auto factor = [&](double part, double wanted, double order) {
    return part > 0 ? std::clamp(std::pow(wanted / part, 1 / order), least, most) : most;
  };
  return {factor(error.size, size, orders.size), factor(error.step, step, orders.step)};
}

Rung Refinement::towards(const TrialRun& from, double error, double reach) const {
  return trials_.nearest(
      scaled(from.rung, cheapest_factors({from.space, from.time}, orders_, error, trials_.dim(), 1 / reach,
                                         trials_.reach().coarser)));
}

Rung Refinement::proposed(const TrialRun& from) const {
  return towards(from, aim * tolerance_, trials_.reach().finer);
}

TrialRun Refinement::begin() {
  if (const std::optional<Rung> rung = trials_.preliminary_rung()) {
    constexpr double nothing = 1; // a relative error: nothing is known
    best_ = {.rung = *rung, .space = nothing, .time = nothing};
    trials_.conclude(*best_, true);
  }
  const std::vector<Rung> rungs = trials_.first_rungs();
  for (std::size_t i = 0; i + 1 < rungs.size(); ++i)
    try {
      return tried(rungs[i]);
    } catch (const UserError&) { // a mesh that coarse cannot be made
    } catch (const SolverFailure&) {
    }
  return tried(rungs.back());
}

TrialRun Refinement::tried(const Rung& rung) {
  TrialRun trial = trials_.run(rung);
  latest_ = trial;
  const auto take = [&] {
    best_ = trial;
    trials_.conclude(trial, true);
  };
  if (trial.error() <= tolerance_)
    try {
      trials_.verify(trial);
    } catch (const Interrupted&) {
      trial.warning = "the run with half the step length did not finish";
      take();
      throw;
    }
  const bool better = trial.meets(tolerance_) ? !met() || trial.seconds <= best_->seconds
                                              : !best_ || (!met() && trial.error() <= best_->error());
  if (better)
    take();
  else
    trials_.conclude(trial, false);
  return trial;
}

double Refinement::seconds_to_next_goal() const {
  constexpr double any_reach = 1e6; // of a rung that is not run
  if (within())
    return trials_.seconds(towards(*best_, best_->error() / 2, any_reach));
  // An earlier rung may be best by chance; what follows comes after the latest one.
  return latest_ ? trials_.seconds(towards(*latest_, aim * tolerance_, any_reach)) : 0;
}

void Refinement::run(bool economise) {
  std::optional<Rung> other_degree = trials_.first_rung_of_other_degree();
  TrialRun last = begin();
  if (last.meets(tolerance_) && !economise)
    return;
  int warned = 0;
  for (int i = 1; i < most_runs; ++i) {
    if (!last.warning.empty() && ++warned == most_warned)
      return;
    const std::optional<Rung> next = following(last, other_degree);
    if (!next)
      return;
    const TrialRun trial = tried(*next);
    if (trial.meets(tolerance_))
      return;
    if (trial.rung.degree == last.rung.degree)
      orders_ = {observed_order(last.space, trial.space, trial.rung.size / last.rung.size, orders_.size),
                 observed_order(last.time, trial.time, trial.rung.step_width() / last.rung.step_width(),
                                orders_.step)};
    else if (trials_.seconds(proposed(last)) < trials_.seconds(proposed(trial)))
      continue;
    last = trial;
  }
  stop_reason_ = fmt::format("the error is still too large after {} runs", most_runs);
}

std::optional<Rung> Refinement::following(const TrialRun& last, std::optional<Rung>& other_degree) {
  constexpr SizeAndStep cure{.size = 0.7, .step = 0.5}; // refines after a warning
  constexpr double little = 0.8;
  Rung next = last.warning.empty() ? proposed(last) : trials_.nearest(scaled(last.rung, cure));
  if (other_degree && last.error() > tolerance_ && trials_.seconds(*other_degree) < trials_.seconds(next))
    next = *other_degree;
  if (next == last.rung) {
    if (last.error() <= tolerance_)
      return std::nullopt;
    const bool in_space = last.space > last.time;
    next = trials_.nearest(scaled(last.rung, {in_space ? little : 1, in_space ? 1 : little}));
  }
  const double expected = trials_.seconds(next);
  console_.line(fmt::format("next: {}, about {:.2g} s", trials_.words(next), expected));
  if (budget_ && elapsed_.seconds() + expected > *budget_) {
    console_.line(fmt::format("the next run would exceed the budget of {:.3g} s (--budget)", *budget_));
    const std::optional<Rung> fitting = within_budget(last.rung, next, other_degree);
    if (!fitting) {
      stop_reason_ = fmt::format("the next run would exceed the budget of {:.3g} s", *budget_);
      return std::nullopt;
    }
    next = *fitting;
  }
  if (next == other_degree)
    other_degree.reset();
  return next;
}

/// Alternative to the rung `next` if that would exceed the budget: the rung `other_degree`, or a smaller
/// refinement of `last`; absent if the remaining time permits neither.
std::optional<Rung> Refinement::within_budget(const Rung& last, const Rung& next,
                                              const std::optional<Rung>& other_degree) {
  constexpr double worth = 0.9; // the least change of a size or a step
  std::vector<Rung> others;
  if (other_degree)
    others.push_back(*other_degree);
  for (const double part : {0.75, 0.5, 0.25}) {
    const double wider = std::pow(next.size / last.size, part),
                 longer = std::pow(next.step_width() / last.step_width(), part);
    Rung between = next;
    between.size = two_digits(last.size * wider);
    if (std::min(wider, longer) < worth)
      others.push_back(trials_.nearest(between.with_steps(longer * last.step_width() / next.step_width())));
  }
  const double left = *budget_ - elapsed_.seconds();
  for (const Rung& rung : others)
    if (const double expected = trials_.seconds(rung); expected <= left) {
      console_.line(fmt::format("instead: {}, about {:.2g} s", trials_.words(rung), expected));
      return rung;
    }
  return std::nullopt;
}

namespace {

std::string sentence(const Refinement& refinement, const TrialRuns& trials, const AccuracyAsked& asked,
                     const std::string& end) {
  const TrialRun& best = *refinement.best();
  std::string text =
      fmt::format("relative error of {}: {:g} requested, ", asked.quantities.front(), asked.error);
  if (best.seconds == 0)
    return text + fmt::format("no error estimate yet: {}; {}, {:.2g} s in all", end, trials.words(best.rung),
                              refinement.seconds());
  text += fmt::format("{:.2e} estimated (space {:.1e}, time {:.1e}", best.error(), best.space, best.time);
  if (best.search > 0)
    text += fmt::format(", search {:.1e}", best.search);
  return text + fmt::format("): {}; {}, {:.2g} s for this run, {:.2g} s in all; {} would take about {:.2g} s",
                            end, trials.words(best.rung), best.seconds, refinement.seconds(),
                            refinement.within() ? "half of the estimated error" : "the requested error",
                            refinement.seconds_to_next_goal());
}

} // namespace

int refine_to_accuracy(MPI_Comm comm, Refinement& refinement, const TrialRuns& trials,
                       const AccuracyAsked& asked, const std::filesystem::path& out, const Console& console) {
  const auto conclude = [&](const std::string& end) {
    forget_deadline();
    if (refinement.best())
      console.line(fmt::format("{}\nresults in {}, whose scene.toml has this mesh and these steps",
                               sentence(refinement, trials, asked, end), out.string()));
  };
  bool interrupted = false;
  try {
    refinement.run(false);
  } catch (const Interrupted&) {
    if (!refinement.best())
      throw;
    interrupted = true;
  } catch (const UserError&) { // on all ranks, like the next
    conclude("not met, the next run failed");
    throw;
  } catch (const SolverFailure&) {
    conclude("not met, the next run failed");
    throw;
  }
  const bool late = time_is_up(comm), met = refinement.met();
  const std::string &warning = refinement.best()->warning, &stop_reason = refinement.stop_reason();
  conclude(met                ? "met"
           : late             ? "not met, the budget is spent"
           : interrupted      ? "not met, interrupted"
           : !warning.empty() ? "not verified, " + warning
                              : "not met" + (stop_reason.empty() ? "" : ", " + stop_reason));
  return met                    ? exit_status::done
         : interrupted && !late ? exit_status::interrupted
                                : exit_status::check_failed;
}

} // namespace signorini::accuracy
