// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/trials.h"
#include "accuracy/analysis.h"
#include "accuracy/error_estimate.h"
#include "accuracy/grading.h"
#include "accuracy/measure.h"
#include "accuracy/quantities.h"
#include "accuracy/rung_costs.h"
#include "base/text.h"
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace signorini::accuracy {
namespace {

/// Common base of trial runs with the adjoint estimate and with error bars.
class MeasuredTrials : public TrialRuns {
public:
  MeasuredTrials(MPI_Comm comm, const scene::Scene& scene, SamplePoints samples, Quantity quantity,
                 const Console& console, KeepTrial keep)
      : comm_(comm), scene_(scene), samples_(std::move(samples)), quantity_(std::move(quantity)),
        console_(console), keep_(std::move(keep)) {}

  [[nodiscard]] std::string title() const override { return quantity_.title; }
  [[nodiscard]] int dim() const override { return samples_.dim; }
  [[nodiscard]] std::vector<Rung> first_rungs() const override { return {nearest(own_rung(scene_))}; }

  [[nodiscard]] double seconds(const Rung& rung) override {
    if (!costs_)
      costs_ = price();
    double sum = 0;
    for (const Rung& one : runs(rung))
      sum += costs_->seconds(one);
    return sum;
  }

  [[nodiscard]] std::string words(const Rung& rung) const override { return accuracy::words(rung, scene_); }

  void verify(TrialRun& trial) override {
    constexpr double half = 0.5, of_difference = 2; // of first order, as fronts of an impact at best
    const Measured own = known(trial.rung), finer = known(trial.rung.with_steps(half));
    const std::optional<double> apart = distance(quantity_, own, finer);
    trial.time = std::max(trial.time, of_difference * apart.value_or(1));
    trial.grounds +=
        fmt::format(", {} change of the value with steps of half the length", percent(apart.value_or(1)));
    trial.warning = own.warning(quantity_);
    console_.line(fmt::format("{}: {}{}", words(trial.rung), trial.grounds,
                              trial.warning.empty() ? "" : "; not verified: " + trial.warning));
  }

  void conclude(const TrialRun& trial, bool better) override {
    if (better && keep_)
      keep_(trial);
  }

protected:
  /// Rungs that have to run to estimate the error of a rung, including the rung itself.
  [[nodiscard]] virtual std::vector<Rung> runs(const Rung& rung) const = 0;
  /// Measurements of a rung, which is run unless its measurements are stored.
  virtual Measured known(const Rung& rung) = 0;

  MPI_Comm comm_;
  const scene::Scene& scene_;
  SamplePoints samples_;
  Quantity quantity_;
  const Console& console_;
  KeepTrial keep_;

private:
  /// Predicts the costs of the rungs that a refinement may reach.
  [[nodiscard]] RungCosts price() const {
    std::vector<Rung> rungs;
    for (const std::optional<Rung>& one :
         {std::optional(first_rungs().front()), first_rung_of_other_degree()})
      if (one) {
        rungs.insert(rungs.end(), 2, *one);
        rungs.back().size /= reach().finer;
      }
    return accuracy::predict_costs(comm_, scene_, rungs, samples_, {quantity_}, quantity_.name == "J");
  }

  std::optional<RungCosts> costs_;
};

std::string listed(const adjoint::ErrorParts& parts) {
  std::string text = fmt::format("space {:+.2e}, time {:+.2e}", *parts.space, parts.time);
  if (parts.initial != 0)
    text += fmt::format(", initial data {:+.2e}", parts.initial);
  if (parts.desired != 0)
    text += fmt::format(", desired displacement {:+.2e}", parts.desired);
  return text;
}

class AdjointTrials final : public MeasuredTrials {
public:
  using MeasuredTrials::MeasuredTrials;
  [[nodiscard]] Reach reach() const override { return {.order = 2, .finer = 8, .coarser = 2}; }
  [[nodiscard]] Rung nearest(const Rung& rung) const override { return rung; }

  TrialRun run(const Rung& rung) override {
    const Measured measured = measure(comm_, on_rung(scene_, rung), samples_, {}, true);
    ran_ = rung, last_ = measured;
    const double value = measured.numbers.at("J"), J = std::abs(value);
    const adjoint::ErrorParts& parts = *measured.estimate;
    const adjoint::ErrorParts relative{*parts.space / J, parts.time / J, parts.initial / J,
                                       parts.desired / J};
    const double error = cautious_bound(relative),
                 time = std::abs(relative.time) / relative.sum_of_moduli() * error;
    by_mesh_ = error_by_mesh(rung, {value, parts});
    TrialRun trial{.rung = rung,
                   .space = std::max(error - time, by_mesh_.value_or(0)),
                   .time = time,
                   .seconds = measured.seconds};
    trial.grounds = fmt::format("estimated relative error at most {:.2e}", trial.error());
    console_.line(fmt::format("{}: J {:.6e}, {} ({}{}), {} unknowns, {:.2g} s", words(rung), value,
                              trial.grounds, listed(relative),
                              by_mesh_ ? fmt::format("; {:.1e} by a mesh twice as coarse", *by_mesh_) : "",
                              measured.unknowns, measured.seconds));
    return trial;
  }

  void verify(TrialRun& trial) override {
    MeasuredTrials::verify(trial);
    if (!by_mesh_ && trial.warning.empty())
      trial.warning = no_coarser_mesh;
  }

private:
  [[nodiscard]] std::vector<Rung> runs(const Rung& rung) const override { return {coarser(rung), rung}; }

  /// Possible relative error of J due to the mesh, by comparison with one twice as coarse; absent if there is
  /// no such mesh.
  std::optional<double> error_by_mesh(const Rung& rung, const EstimatedValue& fine) {
    try {
      const Measured there = measure(comm_, on_rung(scene_, coarser(rung)), samples_, {}, true);
      return error_by_coarser_mesh(fine, {there.numbers.at("J"), *there.estimate}, coarser_by) /
             std::abs(fine.J);
    } catch (const UserError&) { // a mesh that coarse cannot be made
    } catch (const SolverFailure&) {
    }
    return std::nullopt;
  }

  static constexpr double coarser_by = 2;
  static Rung coarser(Rung rung) {
    rung.size *= coarser_by;
    return rung;
  }

  Measured known(const Rung& rung) override {
    return rung == ran_ ? last_ : measure(comm_, on_rung(scene_, rung), samples_, {}, false);
  }

  std::optional<double> by_mesh_; ///< of the rung that ran last
  Rung ran_;                      ///< this rung
  Measured last_;
};

class LadderTrials final : public MeasuredTrials {
public:
  using MeasuredTrials::MeasuredTrials;
  [[nodiscard]] Reach reach() const override { return {.order = 1, .finer = 2, .coarser = 2}; }

  [[nodiscard]] std::optional<Rung> preliminary_rung() const override {
    return keep_ ? std::optional(runs(first_rungs().front()).front()) : std::nullopt;
  }

  [[nodiscard]] std::optional<Rung> first_rung_of_other_degree() const override {
    Rung raised = first_rungs().front();
    if (raised.degree != 1)
      return std::nullopt;
    raised.degree = 2;
    return raised;
  }

  /// The rung nearest to `rung` for which rungs with steps of twice and four times the length exist.
  [[nodiscard]] Rung nearest(const Rung& rung) const override {
    Rung next = rung;
    if (rung.has_varying_steps())
      next.tolerance = std::min(rung.tolerance, scene::Time::most_tolerance / (coarsest * coarsest));
    else
      next.steps = (rung.steps + coarsest - 1) / coarsest * coarsest;
    return next;
  }

  TrialRun run(const Rung& rung) override {
    std::vector<RungResult> results;
    for (const Rung& one : runs(rung))
      results.push_back({one, known(one)});
    const std::optional<ReferenceBar> bar = errors(quantity_, results, {}).bar;
    constexpr double nothing = 1; // a relative error: nothing is known
    const Measured& measured = *results.back().measured;
    const double space = bar && bar->size ? *bar->size : nothing,
                 time = bar && bar->step ? *bar->step : nothing;
    const std::string found = value(measured);
    const std::string grounds = fmt::format("{}error bar {} (from the size {}, from the step {}{})", found,
                                            percent(space + time), percent(space), percent(time),
                                            bar && bar->asymptotic ? "" : "; not in the asymptotic range");
    console_.line(fmt::format("{}: {}, {} unknowns, {:.2g} s", words(rung), grounds, measured.unknowns,
                              measured.seconds));
    return {.rung = rung, .space = space, .time = time, .seconds = measured.seconds, .grounds = grounds};
  }

private:
  static constexpr int coarsest = 4;

  [[nodiscard]] std::vector<Rung> runs(const Rung& rung) const override {
    std::vector<Rung> all;
    for (const auto& [wider, longer] : {std::pair(coarsest, 1), {2, 1}, {1, coarsest}, {1, 2}, {1, 1}}) {
      all.push_back(rung);
      all.back().size *= wider;
      all.back() = all.back().with_steps(longer);
    }
    return all;
  }

  Measured known(const Rung& rung) override {
    const auto [found, missing] = measured_.try_emplace(rung);
    if (missing)
      found->second = measure(comm_, on_rung(scene_, rung), samples_, {quantity_}, false);
    if (!quantity_.field && !std::isfinite(found->second.numbers.at(quantity_.name)))
      throw UserError(fmt::format("--quantity: the motion with {} has no {}: the body must leave what it hit "
                                  "before time.end",
                                  words(rung), quantity_.title));
    return found->second;
  }

  [[nodiscard]] std::string value(const Measured& measured) const {
    if (quantity_.field)
      return "";
    return fmt::format("{} {:.6g}{}{}, ", quantity_.title, measured.numbers.at(quantity_.name),
                       quantity_.unit.empty() ? "" : " ", quantity_.unit);
  }

  std::map<Rung, Measured> measured_;
};

/// The requested quantity; J if none is requested. Throws UserError unless exactly one is selected.
Quantity the_quantity(const scene::Scene& scene, const std::vector<std::string>& names, int dim,
                      const char* option) {
  std::vector<std::string> allowed;
  for (const Quantity& quantity : quantities(scene, dim))
    if (!quantity.already_relative) // a relative quantity is its own error
      allowed.push_back(quantity.name);
  if (names.empty() && !scene.objective)
    throw UserError(fmt::format("{}: a scene without an objective needs --quantity; choose one of {}", option,
                                list(allowed)));
  const Quantity found = names.empty() ? Quantity{"J", "J", ""} : chosen(scene, names, dim).front();
  if (names.size() > 1 || found.already_relative)
    throw UserError(fmt::format("{}: found --quantity {}; choose one of {}", option, fmt::join(names, ","),
                                list(allowed)));
  return found;
}

void require_size(const scene::Scene& scene, const Quantity& quantity, const char* option) {
  if (scene.mesh.meshed())
    throw UserError(fmt::format("{}: has no effect on a mesh; use a geometry, such as a .geo", option));
  if (quantity.name == "J" && scene.mesh.degree != 1)
    throw UserError(fmt::format("{}: found mesh.degree = {}; set it to 1, since the error estimate in space "
                                "compares degree 1 with degree 2",
                                option, scene.mesh.degree));
}

} // namespace

std::unique_ptr<TrialRuns> study_trials(MPI_Comm comm, const scene::Scene& scene,
                                        const std::vector<std::string>& names, const char* option,
                                        const Console& console, KeepTrial keep) {
  const Quantity asked = the_quantity(scene, names, 2, option);
  if (asked.name == "J")
    require_estimable(scene, option, "choose another --quantity");
  require_size(scene, asked, option);
  require_size_takes_effect(comm, scene);
  SamplePoints samples(comm, scene);
  Quantity quantity = the_quantity(scene, names, samples.dim, option);
  if (quantity.name == "J")
    return std::make_unique<AdjointTrials>(comm, scene, std::move(samples), std::move(quantity), console,
                                           std::move(keep));
  return std::make_unique<LadderTrials>(comm, scene, std::move(samples), std::move(quantity), console,
                                        std::move(keep));
}

} // namespace signorini::accuracy
