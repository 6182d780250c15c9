// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/summary.h"
#include "accuracy/analysis.h"
#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace signorini::accuracy {

namespace {

/// Value of a quantity as text.
std::string value_text(double value) { return std::isfinite(value) ? fmt::format("{:.6g}", value) : "none"; }

std::string shown(const std::optional<double>& error) {
  constexpr int digits = 3;
  return error ? percent(*error, digits) : "-";
}

/// Text of an order and its range; "none" outside of the asymptotic range.
std::string shown(const std::optional<Order>& order) {
  if (!order)
    return "-";
  const auto& [slope, least, largest, asymptotic] = *order;
  return asymptotic ? fmt::format("{:.2f} ({:.2f} to {:.2f})", slope, least, largest)
                    : fmt::format("none ({:.1f} to {:.1f})", least, largest);
}

/// Relative error of J on the scene's own rung: the error estimate, else the error against the reference;
/// absent if neither is known.
std::optional<double> own_error(const std::vector<Errors>& errors, const std::vector<RungResult>& results,
                                const scene::Scene& scene) {
  const auto J = std::ranges::find(errors, "J", [](const Errors& one) { return one.quantity.name; });
  const auto own = std::ranges::find(results, own_rung(scene), &RungResult::rung);
  if (J == errors.end() || own == results.end())
    return std::nullopt;
  const auto i = static_cast<std::size_t>(own - results.begin());
  return J->estimate[i] ? J->estimate[i] : J->error[i];
}

/// Describes the reference against which a quantity's errors are taken.
std::string against(const Errors& errors) {
  if (errors.exact)
    return "errors against the exact value";
  return errors.bar ? fmt::format("errors against the finest rung ({})", words(*errors.bar))
                    : "errors against the finest rung, whose own error is unknown";
}

} // namespace

Summary::Summary(const scene::Scene& scene, const std::vector<Quantity>& wanted,
                 const std::vector<RungResult>& results, const std::vector<SearchCost>& searches,
                 const Exact& exact)
    : scene_(scene), results_(results), searches_(searches) {
  for (const Quantity& quantity : wanted) {
    errors_.push_back(errors(quantity, results, exact));
    std::ranges::move(orders(quantity, results, exact), std::back_inserter(orders_));
    std::ranges::move(sentences(errors_.back(), results, scene), std::back_inserter(sentences_));
  }
  if (const std::optional<double> error = own_error(errors_, results, scene); error && !searches.empty())
    sentences_.push_back(sentence(searches, *error));
  std::ranges::stable_sort(orders_, {}, [](const Orders& one) {
    return std::tuple(one.degree, one.scheme, one.varying_steps, one.graded);
  });
}

void Summary::write(const RungCache& store) const {
  constexpr const char* of_searches = "search.csv";
  if (searches_.empty())
    store.remove(of_searches);
  else
    store.write(of_searches, csv(searches_));
  store.write("study.csv", csv(scene_, results_, errors_));
  store.write("study.json", json(scene_, results_, searches_.size(), errors_, orders_, sentences_));
}

void Summary::show(const Console& console) const {
  show_rungs(console);
  for (const Errors& one : errors_)
    show_errors(one, console);
  console.line("\n\"at most\": largest error of this rung and all finer ones; *: no cheaper rung has a "
               "smaller error");
  if (std::ranges::any_of(results_, [](const RungResult& result) { return result.rung.graded; }))
    console.line("~: graded mesh with as many elements as the uniform mesh of that size");
  show_orders(console);
  show_searches(console);
  show_warnings(console);
  console.line("");
  for (const std::string& sentence : sentences_)
    console.line(sentence);
}

std::string Summary::size(const RungResult& result) {
  return fmt::format("{}{:.4g}", result.rung.graded ? "~" : "", result.rung.size);
}

std::string Summary::step(const RungResult& result) const {
  const Rung& rung = result.rung;
  return rung.has_varying_steps() ? fmt::format("tol {:.2g}", rung.tolerance)
                                  : fmt::format("{:.3g}", scene_.time.end / rung.steps);
}

void Summary::show_rungs(const Console& console) const {
  console.line(fmt::format("\n{:>4} {:>10} {:>11} {:>6} {:<18} {:>9} {:>8} {:>6}", "rung",
                           scene_.mesh.size ? "size, m" : "scale", "step, s", "degree", "scheme", "unknowns",
                           "seconds", "MB"));
  for (std::size_t i = 0; i < results_.size(); ++i) {
    const auto& [rung, run] = results_[i];
    if (run)
      console.line(fmt::format("{:>4} {:>10} {:>11} {:>6} {:<18} {:>9} {:>8.3g} {:>6.0f}", i + 1,
                               size(results_[i]), step(results_[i]), rung.degree, scene::name(rung.scheme),
                               run->unknowns, run->seconds, run->memory / 1e6));
  }
}

void Summary::show_searches(const Console& console) const {
  if (searches_.empty())
    return;
  console.line(fmt::format("\nthe optimizer's accuracy at {}; above least: (J - J*)/|J*|, where J* is the "
                           "least J of all searches",
                           words(own_rung(scene_), scene_)));
  console.line(table(searches_));
}

void Summary::show_warnings(const Console& console) const {
  struct Alike {
    std::string name, message; // the message of the most expensive rung
    std::vector<std::size_t> rungs;
  };
  std::vector<Alike> warnings;
  for (std::size_t i = 0; i < results_.size(); ++i)
    if (results_[i].measured)
      for (const Warning& one : results_[i].measured->warnings) {
        auto at = std::ranges::find(warnings, one.name, &Alike::name);
        if (at == warnings.end())
          at = warnings.insert(at, {one.name, {}, {}});
        at->message = one.message;
        if (at->rungs.empty() || at->rungs.back() != i + 1)
          at->rungs.push_back(i + 1);
      }
  for (Alike& one : warnings) {
    const std::size_t last = one.rungs.back();
    one.rungs.pop_back();
    const std::string others =
        one.rungs.empty() ? ""
                          : fmt::format(" (also rung{} {}; see study.json)", one.rungs.size() == 1 ? "" : "s",
                                        fmt::join(one.rungs, ", "));
    console.line(fmt::format("warning: rung {}: {}{}", last, one.message, others));
  }
}

void Summary::show_errors(const Errors& errors, const Console& console) const {
  const Quantity& quantity = errors.quantity;
  const std::string unit = quantity.unit.empty() || quantity.field ? "" : ", " + quantity.unit;
  console.line(fmt::format("\n{}{}: {}{}", quantity.title, unit, against(errors),
                           quantity.converges ? "" : "; this quantity need not converge"));
  console.line(fmt::format("{:>4} {:>10} {:>11} {:>13} {:>9} {:>9} {:>9} {:>8}", "rung",
                           scene_.mesh.size ? "size, m" : "scale", "step, s", quantity.field ? "" : "value",
                           "error", "at most", "estimate", "est/err"));
  for (std::size_t i = 0; i < results_.size(); ++i) {
    const auto& [rung, run] = results_[i];
    if (!run)
      continue;
    console.line(fmt::format("{:>4} {:>10} {:>11} {:>13} {:>9} {:>9} {:>9} {:>6} {}", i + 1,
                             size(results_[i]), step(results_[i]),
                             quantity.field ? "" : value_text(run->numbers.at(quantity.name)),
                             errors.reference == i ? "reference" : shown(errors.error[i]),
                             shown(errors.envelope[i]), shown(errors.estimate[i]),
                             errors.effectivity[i] ? fmt::format("{:.2f}", *errors.effectivity[i]) : "-",
                             errors.pareto[i] ? '*' : ' '));
  }
}

void Summary::show_orders(const Console& console) const {
  const auto out_of_range = [](const std::optional<Order>& order) { return order && !order->asymptotic; };
  bool any = false;
  const Orders* last = nullptr;
  for (const Orders& one : orders_) {
    if (!last || last->degree != one.degree || last->scheme != one.scheme ||
        last->varying_steps != one.varying_steps || last->graded != one.graded)
      console.line(fmt::format("\ndegree {}, {}{}:\n{:<20}{:<21}{:<21}{}", one.degree,
                               scene::name(one.scheme),
                               one.varying_steps ? one.graded ? ", steps chosen, graded" : ", steps chosen"
                               : one.graded      ? ", graded"
                                                 : "",
                               "order of", "in space", "in time", "in both"));
    console.line(fmt::format("{:<20}{:<21}{:<21}{}", one.quantity, shown(one.space), shown(one.time),
                             shown(one.both)));
    any |= out_of_range(one.space) || out_of_range(one.time) || out_of_range(one.both);
    last = &one;
  }
  if (any)
    console.line("\"none\": the values are not in the asymptotic range, since errors do not fall from rung "
                 "to rung as the method predicts");
}

namespace {

/// Describes the basis of a recommendation.
std::string grounds(const Errors& errors, double envelope) {
  std::string text = fmt::format("error at most {} at this rung and all finer ones", percent(envelope));
  if (errors.bar)
    text += fmt::format("; finest rung: {}", words(*errors.bar));
  return text;
}

/// Candidates for a recommendation: the rung with the smallest envelope, and the cheapest rungs within a
/// tolerance, without and with a warning.
struct Best {
  std::optional<std::size_t> nearest, cheapest, warned;
};

/// Whether a run costs less than another one: by its time if the times differ by more than the noise of
/// start-up and machine, else by unknowns times steps. Absent if they cost the same.
std::optional<bool> cheaper(const Measured& one, const Measured& other) {
  constexpr double noise = 0.2, start_up = 0.5; // relative; s
  if (std::abs(one.seconds - other.seconds) > noise * std::max(one.seconds, other.seconds) + start_up)
    return one.seconds < other.seconds;
  const auto work = [](const Measured& run) { return static_cast<double>(run.unknowns) * run.steps; };
  return work(one) == work(other) ? std::nullopt : std::optional(work(one) < work(other));
}

Best best(const Errors& errors, const std::vector<RungResult>& results, double tolerance) {
  Best found;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const std::optional<double>& envelope = errors.envelope[i];
    if (!envelope)
      continue;
    if (!found.nearest || *envelope < *errors.envelope[*found.nearest])
      found.nearest = i;
    if (*envelope > tolerance)
      continue;
    const bool warned = !results[i].measured->warning(errors.quantity).empty();
    std::optional<std::size_t>& cheapest = warned ? found.warned : found.cheapest;
    if (!cheapest || cheaper(*results[i].measured, *results[*cheapest].measured)
                         .value_or(*envelope < *errors.envelope[*cheapest])) // such as another scheme
      cheapest = i;
  }
  return found;
}

} // namespace

std::string percent(double value, int digits) { return fmt::format("{:.{}g} %", 100 * value, digits); }

std::string words(const ReferenceBar& bar) {
  std::string text = fmt::format("error bar {}", percent(bar.value));
  if (!bar.adjoint && !(bar.size && bar.step))
    text += bar.size ? " from the size only, error of the step unknown"
                     : " from the step only, error of the size unknown";
  return bar.asymptotic ? text : text + ", not in the asymptotic range";
}

std::vector<std::string> sentences(const Errors& errors, const std::vector<RungResult>& results,
                                   const scene::Scene& scene) {
  const std::string& title = errors.quantity.title;
  if (std::ranges::none_of(errors.error, [](const auto& error) { return error.has_value(); }))
    return {};
  if (!best(errors, results, 0).nearest)
    return {fmt::format("no recommendation for {}: the finer rungs have no value", title)};
  if (!errors.exact && !errors.bar)
    return {fmt::format(
        "no recommendation for {}: the error bar of the finest rung needs a second size or step", title)};
  const double bar = errors.bar ? errors.bar->value : 0;
  std::vector<std::string> texts;
  for (double target : {0.1, 0.05, 0.01, 0.001}) {
    const auto [nearest, cheapest, warned] = best(errors, results, target - bar);
    if (cheapest) {
      texts.push_back(fmt::format("for an error of {} % in {}: {}, {:.2g} s ({})", 100 * target, title,
                                  words(results[*cheapest].rung, scene), results[*cheapest].measured->seconds,
                                  grounds(errors, *errors.envelope[*cheapest])));
      continue;
    }
    if (warned) {
      texts.push_back(fmt::format("an error of {} % in {} is not verified: {} ({}) has a warning: {}",
                                  100 * target, title, words(results[*warned].rung, scene),
                                  grounds(errors, *errors.envelope[*warned]),
                                  results[*warned].measured->warning(errors.quantity)));
      continue;
    }
    const double reach = *errors.envelope[*nearest] + bar;
    const std::string two = percent(reach), least = two == percent(target) ? percent(reach, 4) : two;
    texts.push_back(fmt::format(
        "an error of {} % in {} is not reached by any rung of this study; the smallest is {}{}", 100 * target,
        title, least, errors.bar ? fmt::format(" (finest rung: {})", words(*errors.bar)) : ""));
    break;
  }
  return texts;
}

} // namespace signorini::accuracy
