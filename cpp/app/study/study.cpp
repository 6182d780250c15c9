#include "app/study/study.h"
#include "app/study/density.h"
#include "app/study/measure.h"
#include "app/study/store.h"
#include "base/collective.h"
#include "base/error.h"
#include "scene/names.h"
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>

namespace signorini::study {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::vector<Quantity> chosen(const scene::Scene& scene, const std::vector<std::string>& names) {
  const std::vector<Quantity> all = quantities(scene);
  std::vector<std::string> allowed;
  for (const Quantity& quantity : all)
    allowed.push_back(quantity.name);
  std::vector<Quantity> wanted;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(all, name, &Quantity::name);
    if (found == all.end()) {
      const std::string near = scene::nearest(name, allowed);
      throw UserError(fmt::format("--quantity: found \"{}\"{}, allowed with this scene: {}", name,
                                  near.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", near),
                                  scene::list(allowed)));
    }
    if (std::ranges::find(wanted, name, &Quantity::name) == wanted.end())
      wanted.push_back(*found);
  }
  if (wanted.empty())
    std::ranges::copy_if(all, std::back_inserter(wanted),
                         [](const Quantity& quantity) { return quantity.name != "gradient"; });
  return wanted;
}

/// The predicted cost of rungs, extrapolated from the last run.
class Prices {
public:
  Prices(int dim, const Rung& known, const Measured& measured, double seconds)
      : dim_(dim), unknowns_(static_cast<double>(measured.unknowns) / relative_unknowns(known, dim)) {
    learn(known, seconds);
  }

  [[nodiscard]] double unknowns(const Rung& rung) const { return unknowns_ * relative_unknowns(rung, dim_); }
  void learn(const Rung& rung, double seconds) { unit_ = seconds / work(rung, dim_); }
  [[nodiscard]] double seconds(const Rung& rung) const { return unit_ * work(rung, dim_); }

private:
  int dim_;
  double unknowns_, unit_ = 0;
};

/// Prices from a few steps of the coarsest rung.
Prices prices(MPI_Comm comm, const scene::Scene& scene, const std::vector<Rung>& rungs,
              const Samples& samples) {
  const Rung* coarsest = &rungs.front();
  for (const Rung& rung : rungs)
    if (std::tuple(-rung.size, rung.degree, rung.steps) <
        std::tuple(-coarsest->size, coarsest->degree, coarsest->steps))
      coarsest = &rung;
  Rung few = *coarsest;
  constexpr int timed = 10;
  few.steps = std::min(few.steps, timed);
  scene::Scene part = on_rung(scene, few);
  part.time.end = scene.time.end / coarsest->steps * few.steps;
  part.time.step = part.time.end / few.steps;
  const auto start = Clock::now();
  const Measured measured =
      measure(comm, part, samples, {{"displacement", "", "", true}}, scene.objective.has_value());
  return {samples.dim, few, measured, seconds_since(start)};
}

std::string duration(double seconds) {
  if (seconds < 100)
    return fmt::format("{:.2g} s", seconds);
  return seconds < 6000 ? fmt::format("{:.0f} min", seconds / 60) : fmt::format("{:.1f} h", seconds / 3600);
}

void show_prices(const Console& console, const std::vector<Rung>& rungs, const Prices& prices,
                 const scene::Scene& scene) {
  double all = 0;
  console.line(fmt::format("{:>5} {:>12} {:>10}  {}", "rung", "unknowns", "about", ""));
  for (std::size_t i = 0; i < rungs.size(); ++i) {
    all += prices.seconds(rungs[i]);
    console.line(fmt::format("{:>5} {:>12.0f} {:>10}  {}", i + 1, prices.unknowns(rungs[i]),
                             duration(prices.seconds(rungs[i])), words(rungs[i], scene)));
  }
  console.line(fmt::format("all {}: about {}", rungs.size(), duration(all)));
}

std::string percent(const std::optional<double>& value) {
  return value ? fmt::format("{:.3g} %", 100 * *value) : "-";
}

std::string shown(const std::optional<Orders::Order>& order) {
  return order ? fmt::format("{:.2f} ({:.2f} to {:.2f})", order->slope, order->least, order->largest) : "-";
}

/// The tables of the rungs that have run, on rank 0: to files and, at the end, to the console.
class Summary {
public:
  Summary(const scene::Scene& scene, const std::vector<Quantity>& wanted, const std::vector<Result>& results,
          const Exact& exact)
      : scene_(scene), results_(results) {
    for (const Quantity& quantity : wanted) {
      errors_.push_back(errors(quantity, results, exact));
      std::ranges::move(orders(quantity, results, exact), std::back_inserter(orders_));
      std::ranges::move(study::sentences(errors_.back(), results, scene), std::back_inserter(sentences_));
    }
  }

  void write(const Store& store) const {
    store.write("study.csv", csv(results_, errors_, scene_.time.end));
    store.write("study.json", json(scene_, results_, errors_, orders_, sentences_));
  }

  void show(const Console& console) const {
    for (const Errors& one : errors_) {
      console.line(fmt::format("\n{}: error against the {}", one.quantity.title,
                               one.exact ? "exact one" : "finest rung"));
      console.line(fmt::format("{:>5} {:>10} {:>9} {:>8}  {:>9} {:>10} {:>11}    {}", "rung", "unknowns",
                               "seconds", "MB", "error", "estimate", "effectivity",
                               "(* no cheaper rung is as accurate)"));
      for (std::size_t i = 0; i < results_.size(); ++i)
        if (const std::optional<Measured>& run = results_[i].measured)
          console.line(fmt::format("{:>5} {:>10} {:>9.3g} {:>8.0f}  {:>9} {:>10} {:>11}  {} {}", i + 1,
                                   run->unknowns, run->seconds, run->memory / 1e6,
                                   one.reference == i ? "reference" : percent(one.error[i]),
                                   percent(one.estimate[i]), effectivity(one, i), one.pareto[i] ? '*' : ' ',
                                   words(results_[i].rung, scene_)));
    }
    if (!orders_.empty())
      console.line(fmt::format("\n{:<14} {:<8} {:<20} {:<24} {:<24} {}", "order of", "degree", "scheme",
                               "in space", "in time", "in both"));
    for (const Orders& one : orders_)
      console.line(fmt::format("{:<14} {:<8} {:<20} {:<24} {:<24} {}", one.quantity, one.degree,
                               scene::name(one.scheme), shown(one.space), shown(one.time), shown(one.both)));
    console.line("");
    for (const std::string& sentence : sentences_)
      console.line(sentence);
  }

private:
  static std::string effectivity(const Errors& one, std::size_t i) {
    return one.effectivity[i] ? fmt::format("{:.2f}", *one.effectivity[i]) : "-";
  }

  const scene::Scene& scene_;
  const std::vector<Result>& results_;
  std::vector<Errors> errors_;
  std::vector<Orders> orders_;
  std::vector<std::string> sentences_;
};

bool on_all(MPI_Comm comm, bool root_says) {
  int flag = root_says;
  MPI_Bcast(&flag, 1, MPI_INT, 0, comm);
  return flag != 0;
}

/// A study under way: its rungs from cheap to dear, and what is known of them.
class Study {
public:
  Study(MPI_Comm comm, const scene::Scene& scene, const Options& options, const std::vector<Quantity>& wanted,
        const Samples& samples, const std::optional<Store>& store, std::optional<Prices>& price,
        const Console& console)
      : comm_(comm), scene_(scene), options_(options), wanted_(wanted), samples_(samples), store_(store),
        price_(price), console_(console), root_(rank(comm) == 0), exact_(exact_values(scene, samples)) {}

  /// Takes what the folder has of the rungs. All, for errors refer to the finest, however early the study
  /// ends.
  void load(const std::vector<Rung>& rungs) {
    if (root_)
      origin_.emplace(scene_, samples_, ranks(comm_));
    for (const Rung& rung : rungs) {
      Kept found;
      if (root_)
        found = store_->load(rung, origin_->of(rung), wanted_);
      kept_ += found.measured.has_value();
      results_.push_back({rung, std::move(found.measured)});
      unfit_.push_back(std::move(found.unfit));
    }
    MPI_Bcast(&kept_, 1, MPI_INT, 0, comm_);
  }

  /// Runs the others, as far as the budget goes. Returns the exit status.
  int run(Clock::time_point start) {
    for (std::size_t i = 0; i < results_.size(); ++i) {
      const Rung& rung = results_[i].rung;
      if (on_all(comm_, results_[i].measured.has_value()))
        continue;
      if (on_all(comm_, options_.budget && seconds_since(start) + price_->seconds(rung) > *options_.budget)) {
        left_ = i;
        return 0;
      }
      if (!unfit_[i].empty())
        console_.line(fmt::format("rung {} of {} runs again: {}", i + 1, results_.size(), unfit_[i]));
      const auto began = Clock::now();
      try {
        results_[i].measured =
            measure(comm_, on_rung(scene_, rung), samples_, wanted_, scene_.objective.has_value());
      } catch (const Interrupted&) {
        constexpr int interrupted = 130;
        return interrupted;
      } catch (const std::exception&) { // perhaps on one rank alone
        if (root_ && ran_ + kept_ > 0)
          Summary(scene_, wanted_, results_, exact_).write(*store_);
        throw;
      }
      if (price_)
        price_->learn(rung, seconds_since(began));
      ++ran_;
      on_root(comm_, [&] { store_->save(rung, origin_->of(rung), *results_[i].measured); });
      console_.line(fmt::format("rung {} of {}: {}: {} unknowns, {:.3g} s; {} so far", i + 1, results_.size(),
                                words(rung, scene_), results_[i].measured->unknowns,
                                results_[i].measured->seconds, duration(seconds_since(start))));
    }
    return 0;
  }

  /// Writes and shows what came out.
  void conclude(const std::filesystem::path& out) const {
    if (ran_ + kept_ == 0) {
      console_.line("no rung has run: nothing is written");
      return;
    }
    on_root(comm_, [&] {
      const Summary summary(scene_, wanted_, results_, exact_);
      summary.write(*store_);
      summary.show(console_);
    });
    if (kept_ > 0)
      console_.line(fmt::format("{} of {} rungs were there already", kept_, results_.size()));
    if (left_)
      console_.line(fmt::format(
          "the budget ends before rung {} of {}, which would take about {}; the same command with "
          "a larger --budget goes on from here",
          *left_ + 1, results_.size(), duration(price_->seconds(results_[*left_].rung))));
    console_.line(fmt::format("results in {}", out.string()));
  }

private:
  MPI_Comm comm_;
  const scene::Scene& scene_;
  const Options& options_;
  const std::vector<Quantity>& wanted_;
  const Samples& samples_;
  const std::optional<Store>& store_; ///< on rank 0
  std::optional<Prices>& price_;
  const Console& console_;
  bool root_;
  Exact exact_;
  std::optional<Origin> origin_; ///< on rank 0
  std::vector<Result> results_;
  std::vector<std::string> unfit_; ///< why the folder's result of a rung is not taken
  int ran_ = 0, kept_ = 0;
  std::optional<std::size_t> left_; ///< the rung before which the budget ends
};

} // namespace

int run_study(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
              const Options& options, const Console& console) {
  const auto start = Clock::now();
  const std::vector<Quantity> wanted = chosen(scene, options.quantities);
  std::vector<Rung> rungs = ladder(scene, options.choice);
  std::optional<Store> store;
  if (!options.dry_run)
    on_root(comm, [&] { store.emplace(out); });
  std::vector<double> sizes;
  std::ranges::transform(rungs, std::back_inserter(sizes), &Rung::size);
  require_answer_to(comm, scene, sizes);
  const Samples samples(comm, scene);
  std::optional<Prices> price;
  Study study(comm, scene, options, wanted, samples, store, price, console);
  std::ranges::stable_sort(rungs, {}, [&](const Rung& rung) { return work(rung, samples.dim); });
  if (options.dry_run || options.budget)
    price = prices(comm, scene, rungs, samples);
  if (options.dry_run) {
    show_prices(console, rungs, *price, scene);
    return 0;
  }
  study.load(rungs);
  const int status = study.run(start);
  study.conclude(out);
  return status;
}

} // namespace signorini::study
