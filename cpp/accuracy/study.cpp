// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/study.h"
#include "accuracy/error_estimate.h"
#include "accuracy/grading.h"
#include "accuracy/quantities.h"
#include "accuracy/rung_costs.h"
#include "accuracy/search_costs.h"
#include "accuracy/summary.h"
#include "base/collective.h"
#include "base/error.h"
#include "base/signals.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace signorini::accuracy {
namespace {

std::string duration(double seconds) {
  if (seconds < 100)
    return fmt::format("{:.2g} s", seconds);
  return seconds < 6000 ? fmt::format("{:.0f} min", seconds / 60) : fmt::format("{:.1f} h", seconds / 3600);
}

void show_prices(const Console& console, const std::vector<Rung>& rungs, const RungCosts& prices,
                 std::size_t searches, const scene::Scene& scene) {
  double all = 0;
  console.line(fmt::format("{:>5} {:>12} {:>10}  {}", "rung", "unknowns", "about", ""));
  for (std::size_t i = 0; i < rungs.size(); ++i) {
    all += prices.seconds(rungs[i]);
    console.line(fmt::format("{:>5} {:>12.0f} {:>10}  {}", i + 1, prices.unknowns(rungs[i]),
                             duration(prices.seconds(rungs[i])), words(rungs[i], scene)));
  }
  console.line(fmt::format("all {}: about {}", rungs.size(), duration(all)));
  if (searches > 0)
    console.line(fmt::format("in addition {} search{}, whose number of sweeps and time cannot be predicted",
                             searches, searches > 1 ? "es" : ""));
}

bool on_all(MPI_Comm comm, bool root_says) {
  int flag = root_says;
  MPI_Bcast(&flag, 1, MPI_INT, 0, comm);
  return flag != 0;
}

/// State of a study: rungs in ascending order of cost, searches, and results.
class Study {
public:
  Study(MPI_Comm comm, const scene::Scene& scene, const Options& options, const std::vector<Quantity>& wanted,
        const SamplePoints& samples, const std::optional<RungCache>& store, std::optional<RungCosts>& price,
        const Elapsed& elapsed, const Console& console)
      : comm_(comm), scene_(scene), options_(options), wanted_(wanted), samples_(samples), store_(store),
        price_(price), elapsed_(elapsed), console_(console), root_(rank(comm) == 0),
        exact_(exact_values(scene, samples)) {}

  /// Loads the results of all rungs that are in the folder, since errors refer to the finest rung even if
  /// this study ends early.
  void load(const std::vector<Rung>& rungs) {
    if (root_)
      origin_.emplace(scene_, samples_, ranks(comm_));
    for (const Rung& rung : rungs) {
      CachedRung found;
      if (root_)
        found = store_->load(rung, origin_->of(rung), wanted_);
      kept_ += found.measured.has_value();
      results_.push_back({rung, std::move(found.measured)});
      unfit_.push_back(std::move(found.unfit));
    }
    MPI_Bcast(&kept_, 1, MPI_INT, 0, comm_);
  }

  /// Runs the rungs that have no results yet, as long as the budget permits. Returns the exit status.
  int run() {
    for (std::size_t i = 0; i < results_.size(); ++i) {
      const Rung& rung = results_[i].rung;
      if (on_all(comm_, results_[i].measured.has_value()))
        continue;
      const double so_far = elapsed_.seconds();
      if (on_all(comm_, options_.budget && so_far + price_->seconds(rung) > *options_.budget)) {
        left_ = i;
        return 0;
      }
      if (!unfit_[i].empty())
        console_.line(fmt::format("rung {} of {} runs again: {}", i + 1, results_.size(), unfit_[i]));
      try {
        results_[i].measured =
            measure(comm_, on_rung(scene_, rung), samples_, wanted_, scene_.objective.has_value());
      } catch (const Interrupted&) {
        return exit_status::interrupted;
      } catch (const std::exception&) { // perhaps on one rank alone
        if (root_ && ran_ + kept_ > 0)
          summary().write(*store_);
        throw;
      }
      if (price_)
        price_->learn(rung, elapsed_.seconds() - so_far);
      ++ran_;
      on_root(comm_, [&] { store_->save(rung, origin_->of(rung), *results_[i].measured); });
      console_.line(fmt::format("rung {} of {}: {}: {} unknowns, {:.3g} s; {} so far", i + 1, results_.size(),
                                words(rung, scene_), results_[i].measured->unknowns,
                                results_[i].measured->seconds, duration(elapsed_.seconds())));
    }
    return 0;
  }

  /// Searches for the optimum with each tolerance, as long as the budget permits. Returns the exit status.
  int search() {
    const std::vector<double>& tolerances = options_.search_tolerances;
    if (left_ || tolerances.empty())
      return 0;
    if (options_.budget)
      stop_after(*options_.budget - elapsed_.seconds());
    int status = 0;
    try {
      const std::optional<Fingerprint> origin = root_ ? std::optional(origin_->of_search()) : std::nullopt;
      for (std::size_t i = 0; i < tolerances.size(); ++i) {
        CachedSearch found;
        if (root_)
          found = store_->load(tolerances[i], *origin);
        if (!on_all(comm_, found.cost.has_value())) {
          if (!found.unfit.empty())
            console_.line(
                fmt::format("search {} of {} runs again: {}", i + 1, tolerances.size(), found.unfit));
          found.cost = search_to(comm_, scene_, tolerances[i]);
          on_root(comm_, [&] { store_->save(*found.cost, *origin); });
          console_.line(fmt::format("search {} of {}: tolerance {:.3g}: {} forward + {} adjoint sweeps, "
                                    "{:.3g} s; {} so far",
                                    i + 1, tolerances.size(), tolerances[i], found.cost->forward_sweeps,
                                    found.cost->adjoint_sweeps, found.cost->seconds,
                                    duration(elapsed_.seconds())));
        }
        if (root_)
          searches_.push_back(*std::move(found.cost));
      }
    } catch (const Interrupted&) {
      if (time_is_up(comm_))
        searches_left_ = true;
      else
        status = exit_status::interrupted;
    } catch (const std::exception&) {
      if (root_)
        summary().write(*store_);
      throw;
    }
    if (options_.budget)
      forget_deadline();
    return status;
  }

  /// Writes and prints the results.
  void conclude(const std::filesystem::path& out) const {
    if (ran_ + kept_ == 0) {
      console_.line(
          left_ ? fmt::format("no rung has run: rung {} would take about {}, and --budget leaves less; "
                              "nothing is written",
                              *left_ + 1, duration(price_->seconds(results_[*left_].rung)))
                : std::string("no rung has run: nothing is written"));
      return;
    }
    on_root(comm_, [&] {
      const Summary all = summary();
      all.write(*store_);
      all.show(console_);
    });
    if (kept_ > 0)
      console_.line(fmt::format("{} of {} rungs were already stored in the folder", kept_, results_.size()));
    if (left_)
      console_.line(fmt::format("the budget ends before rung {} of {}, which would take about {}; to "
                                "continue, repeat the command with a larger --budget",
                                *left_ + 1, results_.size(),
                                duration(price_->seconds(results_[*left_].rung))));
    if (searches_left_ || (left_ && !options_.search_tolerances.empty()))
      console_.line("the budget ends before the last search; to continue, repeat the command with a larger "
                    "--budget");
    console_.line(fmt::format("results in {}", out.string()));
  }

private:
  [[nodiscard]] Summary summary() const { return {scene_, wanted_, results_, searches_, exact_}; }

  MPI_Comm comm_;
  const scene::Scene& scene_;
  const Options& options_;
  const std::vector<Quantity>& wanted_;
  const SamplePoints& samples_;
  const std::optional<RungCache>& store_; ///< on rank 0
  std::optional<RungCosts>& price_;
  const Elapsed& elapsed_;
  const Console& console_;
  bool root_;
  Exact exact_;
  std::optional<Origin> origin_; ///< on rank 0
  std::vector<RungResult> results_;
  std::vector<std::string> unfit_; ///< reasons why results in the folder are not used
  int ran_ = 0, kept_ = 0;
  std::optional<std::size_t> left_;  ///< first rung that was not run because of the budget; absent: none
  std::vector<SearchCost> searches_; ///< on rank 0
  bool searches_left_ = false;       ///< whether a search was not run because of the budget
};

} // namespace

int run_study(MPI_Comm comm, const scene::Scene& given, const std::filesystem::path& out,
              const Options& options, const Console& console) {
  const Elapsed elapsed(comm);
  if (!options.search_tolerances.empty())
    require_searches(given, options.search_tolerances);
  if (options.choice.graded)
    require_estimable(given, "--graded", "leave it out");
  (void)chosen(given, options.quantities, 2); // reports a wrong name before any mesh is read
  scene::Scene scene = given;
  std::vector<Rung> rungs = all_rungs(scene, options.choice);
  std::optional<RungCache> store;
  if (!options.dry_run)
    on_root(comm, [&] { store.emplace(out); });
  std::vector<double> sizes;
  std::ranges::transform(rungs, std::back_inserter(sizes), &Rung::size);
  require_sizes_take_effect(comm, scene, sizes);
  if (options.choice.graded && !options.dry_run) {
    scene.mesh.graded = std::filesystem::absolute(out) / "graded.geo";
    write_graded(comm, scene, scene.mesh.graded, console);
  }
  const SamplePoints samples(comm, scene);
  const std::vector<Quantity> wanted = chosen(scene, options.quantities, samples.dim);
  std::optional<RungCosts> prices;
  Study study(comm, scene, options, wanted, samples, store, prices, elapsed, console);
  std::ranges::stable_sort(rungs, {}, [&](const Rung& rung) { return work(rung, samples.dim); });
  if (!options.dry_run)
    study.load(rungs);                     // before the first solver: Origin
  if (options.dry_run || options.budget) { // graded meshes have as many elements as the others
    std::vector<Rung> priced = rungs;
    for (Rung& rung : priced)
      rung.graded = false;
    prices = predict_costs(comm, scene, priced, samples, wanted, scene.objective.has_value());
  }
  if (options.dry_run) {
    show_prices(console, rungs, *prices, options.search_tolerances.size(), scene);
    return 0;
  }
  int status = study.run();
  if (status == 0)
    status = study.search();
  study.conclude(out);
  return status;
}

} // namespace signorini::accuracy
