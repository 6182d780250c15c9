// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/trials.h"
#include "accuracy/analysis.h"
#include <cmath>
#include <fmt/format.h>

namespace signorini::accuracy {
namespace {

std::string listed(const adjoint::ErrorParts& parts) {
  std::string text = fmt::format("space {:+.2e}, time {:+.2e}", *parts.space, parts.time);
  if (parts.initial != 0)
    text += fmt::format(", initial data {:+.2e}", parts.initial);
  if (parts.desired != 0)
    text += fmt::format(", desired displacement {:+.2e}", parts.desired);
  return text;
}

class AdjointTrials final : public Trials {
public:
  AdjointTrials(MPI_Comm comm, const scene::Scene& scene, const Samples& samples)
      : comm_(comm), scene_(scene), samples_(samples) {}

  [[nodiscard]] double order() const override { return 2; }
  [[nodiscard]] double reach() const override { return 8; }
  [[nodiscard]] bool any_degree() const override { return false; } // see require_size() in suggest.cpp
  [[nodiscard]] Quantity quantity() const override { return {"J", "J", ""}; }
  [[nodiscard]] bool estimates() const override { return true; }

  Trial run(const Rung& rung) override {
    const Measured measured = measure(comm_, on_rung(scene_, rung), samples_, {}, true);
    ran_ = rung, last_ = measured;
    const double value = measured.numbers.at("J"), J = std::abs(value);
    const adjoint::ErrorParts& parts = *measured.estimate;
    const adjoint::ErrorParts relative{*parts.space / J, parts.time / J, parts.initial / J,
                                       parts.desired / J};
    const double error = most(relative), time = std::abs(relative.time) / relative.sum_of_moduli() * error;
    return {rung,
            error - time,
            time,
            measured.seconds,
            fmt::format("J {:.6e}, estimated error at most {:.2e} ({}), {} unknowns, {:.2g} s", value, error,
                        listed(relative), measured.unknowns, measured.seconds),
            fmt::format("by their own estimate at most {:.2e}", error)};
  }

private:
  Measured known(const Rung& rung) override {
    return rung == ran_ ? last_ : measure(comm_, on_rung(scene_, rung), samples_, {}, false);
  }

  MPI_Comm comm_;
  const scene::Scene& scene_;
  const Samples& samples_;
  Rung ran_; ///< the last
  Measured last_;
};

class LadderTrials final : public Trials {
public:
  LadderTrials(MPI_Comm comm, const scene::Scene& scene, const Samples& samples, const Quantity& quantity)
      : comm_(comm), scene_(scene), samples_(samples), quantity_(quantity) {}

  [[nodiscard]] double order() const override { return 1; }
  [[nodiscard]] double reach() const override { return 2; }
  [[nodiscard]] Quantity quantity() const override { return quantity_; }

  [[nodiscard]] std::vector<Rung> runs(const Rung& rung) const override {
    std::vector<Rung> all;
    for (const auto& [wider, longer] : {std::pair(coarsest, 1), {2, 1}, {1, coarsest}, {1, 2}, {1, 1}}) {
      all.push_back(rung);
      all.back().size *= wider;
      all.back() = all.back().with_steps(longer);
    }
    return all;
  }

  /// Steps of twice and four times the length are whole parts of the time, and tolerances for them exist.
  [[nodiscard]] Rung nearest(const Rung& rung) const override {
    Rung next = rung;
    if (rung.chooses_steps())
      next.tolerance = std::min(rung.tolerance, scene::Time::most_tolerance / (coarsest * coarsest));
    else
      next.steps = (rung.steps + coarsest - 1) / coarsest * coarsest;
    return next;
  }

  Trial run(const Rung& rung) override {
    std::vector<Result> results;
    for (const Rung& one : runs(rung))
      results.push_back({one, known(one)});
    const std::optional<ReferenceBar> bar = errors(quantity_, results, {}).bar;
    constexpr double nothing = 1; // is known
    const Measured& measured = *results.back().measured;
    const double space = bar && bar->size ? *bar->size : nothing,
                 time = bar && bar->step ? *bar->step : nothing;
    const std::string found = value(measured);
    const std::string grounds = fmt::format("{}error bar {} (of the size {}, of the step {}{})", found,
                                            percent(space + time), percent(space), percent(time),
                                            bar && bar->asymptotic ? "" : "; not in the asymptotic range");
    return {rung,
            space,
            time,
            measured.seconds,
            fmt::format("{}, {} unknowns, {:.2g} s", grounds, measured.unknowns, measured.seconds),
            grounds};
  }

private:
  static constexpr int coarsest = 4;

  Measured known(const Rung& rung) override {
    const auto [found, missing] = runs_.try_emplace(rung);
    if (missing)
      found->second = measure(comm_, on_rung(scene_, rung), samples_, {quantity_}, false);
    return found->second;
  }

  [[nodiscard]] std::string value(const Measured& measured) const {
    if (quantity_.field)
      return "";
    return fmt::format("{} {:.6g}{}{}, ", quantity_.title, measured.numbers.at(quantity_.name),
                       quantity_.unit.empty() ? "" : " ", quantity_.unit);
  }

  MPI_Comm comm_;
  const scene::Scene& scene_;
  const Samples& samples_;
  Quantity quantity_;
  std::map<Rung, Measured> runs_;
};

} // namespace

void Trials::verify(Trial& trial) {
  constexpr double half = 0.5, of_difference = 2; // of first order, as fronts of an impact at best
  const Measured own = known(trial.rung), finer = known(trial.rung.with_steps(half));
  const std::optional<double> apart = distance(quantity(), own, finer);
  trial.time = std::max(trial.time, of_difference * apart.value_or(1));
  trial.grounds += fmt::format(", {} from steps of half the length", percent(apart.value_or(1)));
  trial.warning = own.warning(quantity());
}

std::unique_ptr<Trials> adjoint_trials(MPI_Comm comm, const scene::Scene& scene, const Samples& samples) {
  return std::make_unique<AdjointTrials>(comm, scene, samples);
}

std::unique_ptr<Trials> ladder_trials(MPI_Comm comm, const scene::Scene& scene, const Samples& samples,
                                      const Quantity& quantity) {
  return std::make_unique<LadderTrials>(comm, scene, samples, quantity);
}

} // namespace signorini::accuracy
