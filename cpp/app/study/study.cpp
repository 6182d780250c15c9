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

} // namespace

int run_study(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
              const Options& options, const Console& console) {
  const auto start = Clock::now();
  const bool root = rank(comm) == 0;
  const std::vector<Quantity> wanted = chosen(scene, options.quantities);
  std::vector<Rung> rungs = ladder(scene, options.choice);
  std::optional<Store> store;
  if (!options.dry_run)
    on_root(comm, [&] { store.emplace(out); });
  std::vector<double> sizes;
  std::ranges::transform(rungs, std::back_inserter(sizes), &Rung::size);
  require_answer_to(comm, scene, sizes);
  const Samples samples(comm, scene);
  const Exact exact = exact_values(scene, samples);
  std::ranges::stable_sort(rungs, {}, [&](const Rung& rung) { return work(rung, samples.dim); });
  std::optional<Origin> origin;
  if (root && !options.dry_run)
    origin.emplace(scene, samples, ranks(comm));
  std::optional<Prices> price;
  if (options.dry_run || options.budget)
    price = prices(comm, scene, rungs, samples);
  if (options.dry_run) {
    show_prices(console, rungs, *price, scene);
    return 0;
  }
  std::vector<Result> results;
  std::vector<std::string> unfit(rungs.size());
  int ran = 0, kept = 0, status = 0;
  for (std::size_t i = 0; i < rungs.size(); ++i) { // all: errors refer to the finest, however early it ends
    Kept found;
    if (root)
      found = store->load(rungs[i], origin->of(rungs[i]), wanted);
    kept += found.measured.has_value();
    results.push_back({rungs[i], std::move(found.measured)});
    unfit[i] = std::move(found.unfit);
  }
  MPI_Bcast(&kept, 1, MPI_INT, 0, comm);
  std::optional<std::size_t> left;
  for (std::size_t i = 0; i < results.size() && status == 0; ++i) {
    const Rung& rung = results[i].rung;
    if (on_all(comm, results[i].measured.has_value()))
      continue;
    if (on_all(comm, options.budget && seconds_since(start) + price->seconds(rung) > *options.budget)) {
      left = i;
      break;
    }
    if (!unfit[i].empty())
      console.line(fmt::format("rung {} of {} runs again: {}", i + 1, results.size(), unfit[i]));
    const auto began = Clock::now();
    try {
      results[i].measured = measure(comm, on_rung(scene, rung), samples, wanted, scene.objective.has_value());
    } catch (const Interrupted&) {
      constexpr int interrupted = 130;
      status = interrupted;
      break;
    } catch (const std::exception&) { // perhaps on one rank alone
      if (root && ran + kept > 0)
        Summary(scene, wanted, results, exact).write(*store);
      throw;
    }
    if (price)
      price->learn(rung, seconds_since(began));
    ++ran;
    on_root(comm, [&] { store->save(rung, origin->of(rung), *results[i].measured); });
    console.line(fmt::format("rung {} of {}: {}: {} unknowns, {:.3g} s; {} so far", i + 1, results.size(),
                             words(rung, scene), results[i].measured->unknowns, results[i].measured->seconds,
                             duration(seconds_since(start))));
  }
  if (ran + kept == 0) {
    console.line("no rung has run: nothing is written");
    return status;
  }
  on_root(comm, [&] {
    const Summary summary(scene, wanted, results, exact);
    summary.write(*store);
    summary.show(console);
  });
  if (kept > 0)
    console.line(fmt::format("{} of {} rungs were there already", kept, results.size()));
  if (left)
    console.line(fmt::format("the budget ends before rung {} of {}, which would take about {}; the same "
                             "command with a larger --budget goes "
                             "on from here",
                             *left + 1, results.size(), duration(price->seconds(results[*left].rung))));
  console.line(fmt::format("results in {}", out.string()));
  return status;
}

} // namespace signorini::study
