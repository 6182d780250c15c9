// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/rung_costs.h"
#include "base/machine.h"
#include <algorithm>
#include <cmath>

namespace signorini::accuracy {
namespace {

/// Times runs of few steps of a scene. Uses processor time, since differences between wall-clock times of
/// short runs are meaningless while other programs run.
class ShortRuns {
public:
  ShortRuns(MPI_Comm comm, const scene::Scene& scene, const SamplePoints& samples,
            const std::vector<Quantity>& wanted, bool estimate)
      : comm_(comm), scene_(scene), samples_(samples), wanted_(wanted), estimate_(estimate) {}

  /// Measures the times of the set-up and of one step of a rung.
  [[nodiscard]] CostModel::Timed time(const Rung& rung) const {
    constexpr double part = 0.5, enough = 1; // of the shortest run; s
    constexpr double least = 2, most = 16;   // factors of the number of steps from run to run
    // The first run in a program takes longer than the others.
    const auto [unknowns, first] = run(rung, 1);
    const double shortest = std::min(first, run(rung, 1).second);
    const double wanted = std::min(part * shortest, enough); // for the steps alone
    double of_steps = 0;
    int steps = 1;
    while (steps < rung.steps && of_steps < wanted) {
      const double more = of_steps > 0 ? std::clamp(1.5 * wanted / of_steps, least, most) : most;
      steps = std::min(static_cast<int>(more * steps), rung.steps);
      of_steps = run(rung, steps).second - shortest;
    }
    const double step = steps > 1 ? std::max(0.0, of_steps) / (steps - 1) : shortest;
    return {unknowns, std::max(0.0, shortest - step), step};
  }

private:
  /// Number of unknowns and seconds of a run with the first `steps` steps of a rung.
  [[nodiscard]] std::pair<double, double> run(const Rung& rung, int steps) const {
    Rung few = rung;
    few.steps = steps;
    scene::Scene part = on_rung(scene_, few);
    part.time.step = scene_.time.end / rung.steps;
    part.time.end = steps * part.time.step;
    const double before = processor_seconds();
    const Measured measured = measure(comm_, part, samples_, wanted_, estimate_);
    double seconds = processor_seconds() - before;
    // The same on all ranks, so that they choose the same number of steps.
    MPI_Allreduce(MPI_IN_PLACE, &seconds, 1, MPI_DOUBLE, MPI_MAX, comm_);
    return {static_cast<double>(measured.unknowns), seconds};
  }

  MPI_Comm comm_;
  const scene::Scene& scene_;
  const SamplePoints& samples_;
  const std::vector<Quantity>& wanted_;
  bool estimate_;
};

/// Range of the rungs of one degree.
struct Extent {
  Rung coarsest; ///< rung with the largest size and the most steps
  double finest; ///< smallest size
};

Extent extent(const std::vector<Rung>& rungs, int degree) {
  Extent found{{}, std::numeric_limits<double>::infinity()};
  for (const Rung& rung : rungs) {
    if (rung.degree != degree)
      continue;
    if (found.coarsest.steps == 0)
      found.coarsest = rung;
    found.coarsest.size = std::max(found.coarsest.size, rung.size);
    found.coarsest.steps = std::max(found.coarsest.steps, rung.steps);
    found.finest = std::min(found.finest, rung.size);
  }
  return found;
}

/// Rung with the largest size, the largest tolerance and the lowest degree among the rungs with steps of
/// varying length; absent if there are no such rungs.
std::optional<Rung> easiest_of_chosen(const std::vector<Rung>& rungs) {
  std::optional<Rung> found;
  for (const Rung& rung : rungs) {
    if (!rung.has_varying_steps())
      continue;
    if (!found)
      found = rung;
    found->size = std::max(found->size, rung.size);
    found->tolerance = std::max(found->tolerance, rung.tolerance);
    found->degree = std::min(found->degree, rung.degree);
  }
  return found;
}

} // namespace

CostModel::CostModel(const std::vector<Timed>& timed, int dim) : exponent_(step_power(dim)) {
  const Timed &coarse = timed.front(), &fine = timed.back();
  const auto fit = [&](double Timed::* part) {
    const double low = std::pow(coarse.unknowns, exponent_), high = std::pow(fine.unknowns, exponent_);
    if (!(high > low))
      return Power{0, fine.*part / high};
    const double factor = std::max(0.0, (fine.*part - coarse.*part) / (high - low));
    const double constant = fine.*part - factor * high;
    return constant >= 0 ? Power{constant, factor} : Power{0, fine.*part / high};
  };
  setup_ = fit(&Timed::setup);
  step_ = fit(&Timed::step);
}

double CostModel::seconds(double unknowns, double steps) const {
  const double power = std::pow(unknowns, exponent_);
  return setup_.constant + setup_.factor * power + steps * (step_.constant + step_.factor * power);
}

const RungCosts::DegreeCost& RungCosts::of(const Rung& rung) const {
  return *std::ranges::find(known_, rung.degree, &DegreeCost::degree);
}

double RungCosts::unknowns(const Rung& rung) const {
  const DegreeCost& known = of(rung);
  const auto& [finest, most] = *known.unknowns.begin();
  const auto& [coarsest, fewest] = *known.unknowns.rbegin();
  const bool between = rung.size > finest && rung.size < coarsest;
  const double power =
      between ? std::log(most / fewest) / std::log(coarsest / finest) : static_cast<double>(known.dim);
  return rung.size < coarsest ? most * std::pow(finest / rung.size, power)
                              : fewest * std::pow(coarsest / rung.size, power);
}

double RungCosts::predicted(const Rung& rung) const {
  const double steps = rung.has_varying_steps() ? steps_by_width_ / rung.step_width() : rung.steps;
  return of(rung).cost.seconds(unknowns(rung), steps);
}

double RungCosts::seconds(const Rung& rung) const {
  return expected_ > 0 ? predicted(rung) * found_ / expected_ : predicted(rung);
}

void RungCosts::learn(const Rung& rung, double seconds) {
  expected_ += predicted(rung);
  found_ += seconds;
}

RungCosts predict_costs(MPI_Comm comm, const scene::Scene& scene, const std::vector<Rung>& rungs,
                        const SamplePoints& samples, const std::vector<Quantity>& wanted, bool estimate) {
  const ShortRuns runs(comm, scene, samples, wanted, estimate);
  double steps_by_width = 0;
  std::vector<Rung> of_one_length = rungs;
  if (const std::optional<Rung> first = easiest_of_chosen(rungs)) {
    const int steps = measure(comm, on_rung(scene, *first), samples, wanted, estimate).steps;
    steps_by_width = steps * first->step_width();
    for (Rung& rung : of_one_length)
      if (rung.has_varying_steps())
        rung.steps = static_cast<int>(std::ceil(steps_by_width / rung.step_width())), rung.tolerance = 0;
  }
  std::vector<RungCosts::DegreeCost> known;
  for (int degree : {1, 2}) {
    const auto [coarsest, finest] = extent(of_one_length, degree);
    if (coarsest.steps == 0)
      continue;
    std::vector<CostModel::Timed> timed{runs.time(coarsest)};
    std::map<double, double> unknowns{{coarsest.size, timed.front().unknowns}};
    // Enough unknowns for constants to be small, and not so many that the runs take long.
    constexpr double enough = 5000;
    Rung finer = coarsest;
    finer.size =
        std::max(finest, coarsest.size * std::pow(timed.front().unknowns / enough, 1.0 / samples.dim));
    if (constexpr double another = 0.8; finer.size < another * coarsest.size) {
      timed.push_back(runs.time(finer));
      unknowns[finer.size] = timed.back().unknowns;
    }
    known.push_back({degree, samples.dim, std::move(unknowns), CostModel(timed, samples.dim)});
  }
  return {std::move(known), steps_by_width};
}

} // namespace signorini::accuracy
