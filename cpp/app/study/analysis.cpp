#include "app/study/analysis.h"
#include "base/fit.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace signorini::study {
namespace {

double norm(const std::vector<double>& field) {
  double sum = 0;
  for (double x : field)
    sum += x * x;
  return std::sqrt(sum);
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

std::optional<double> finite(double value) {
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

/// A relative difference: 0 if both are zero, absent if `size` alone is.
std::optional<double> relative(double difference, double size) {
  return difference == 0 && size == 0 ? 0 : finite(difference / size);
}

/// The distance to known values, of another run or exact; absent where one of them is not finite.
template <class Known>
std::optional<double> distance_to(const Quantity& quantity, const Measured& run, const Known& known) {
  if (quantity.field) {
    const std::vector<double>& b = known.fields.at(quantity.name);
    return relative(difference(run.fields.at(quantity.name), b), norm(b));
  }
  const double b = known.numbers.at(quantity.name), off = std::abs(run.numbers.at(quantity.name) - b);
  return quantity.absolute ? finite(off) : relative(off, std::abs(b));
}

bool is_finite(const Quantity& quantity, const Measured& run) {
  return std::isfinite(quantity.field ? norm(run.fields.at(quantity.name)) : run.numbers.at(quantity.name));
}

bool finer(const Rung& a, const Rung& b) {
  return std::tuple(-a.size, a.steps, a.degree) > std::tuple(-b.size, b.steps, b.degree);
}

bool alike(const Rung& a, const Rung& b) { return a.degree == b.degree && a.scheme == b.scheme; }

/// The slope of all points, and of neighbours.
std::optional<Orders::Order> fit(const std::vector<std::pair<double, double>>& points) {
  const double slope = log_log_slope(points);
  if (!std::isfinite(slope))
    return std::nullopt;
  Orders::Order order{slope, std::numeric_limits<double>::infinity(),
                      -std::numeric_limits<double>::infinity()};
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double local = log_log_slope({points[i - 1], points[i]});
    order.least = std::min(order.least, local);
    order.largest = std::max(order.largest, local);
  }
  return order;
}

/// Order along a chain of rungs from coarse to fine whose widths are given: of the differences of neighbours
/// or, given an exact value, of errors.
std::optional<Orders::Order> order(const Quantity& quantity,
                                   const std::vector<std::pair<double, const Measured*>>& chain,
                                   const Exact& exact = {}) {
  constexpr double rounding = 1e-9; // below it, and for long runs somewhat above, errors do not converge
  std::vector<std::pair<double, double>> points;
  const auto add = [&](double width, std::optional<double> value) {
    if (value && *value > rounding)
      points.emplace_back(width, *value);
  };
  if (exact.knows(quantity))
    for (const auto& [width, run] : chain)
      add(width, distance_to(quantity, *run, exact));
  else
    for (std::size_t i = 0; i + 1 < chain.size(); ++i)
      add(chain[i].first, distance_to(quantity, *chain[i].second, *chain[i + 1].second));
  return fit(points);
}

/// Rungs of one degree and scheme that have run, from coarse to fine.
using Family = std::vector<const Result*>;

std::vector<Family> families(const std::vector<Result>& results) {
  std::vector<Family> all;
  for (const Result& result : results) {
    if (!result.measured)
      continue;
    const auto own = std::ranges::find_if(
        all, [&](const Family& family) { return alike(family.front()->rung, result.rung); });
    (own == all.end() ? all.emplace_back() : *own).push_back(&result);
  }
  for (Family& family : all)
    std::ranges::sort(family, [](const Result* a, const Result* b) { return finer(b->rung, a->rung); });
  return all;
}

Orders orders_of(const Quantity& quantity, const Family& members, const Exact& exact) {
  const Rung& finest = members.back()->rung;
  Orders found{quantity.name, finest.degree, finest.scheme, {}, {}, {}};
  using Chain = std::vector<std::pair<double, const Measured*>>;
  Chain space, time, both;
  int most_steps = 0;
  double least_size = finest.size;
  for (const Result* member : members)
    most_steps = std::max(most_steps, member->rung.steps);
  for (const Result* member : members) {
    if (member->rung.steps == most_steps)
      space.emplace_back(member->rung.size, &*member->measured);
    if (member->rung.size == least_size)
      time.emplace_back(1.0 / member->rung.steps, &*member->measured);
  }
  // From the finest rung back, each time to the next coarser size with the next longer step.
  const Rung* last = nullptr;
  for (auto member = members.rbegin(); member != members.rend(); ++member) {
    const Rung& rung = (*member)->rung;
    const bool next = !last ? rung.steps == most_steps && rung.size == least_size
                            : rung.size > last->size && rung.steps < last->steps;
    if (!next)
      continue;
    both.emplace_back(1.0 / rung.steps, &*(*member)->measured);
    last = &rung;
  }
  std::ranges::reverse(both);
  // In space or time alone errors would stagnate at that of the other kind: no exact values.
  found.space = order(quantity, space);
  found.time = order(quantity, time);
  found.both = order(quantity, both, exact);
  return found;
}

/// The error of a run by Richardson extrapolation from its differences to the next coarser ones, if they fall
/// with the observed orders.
std::optional<double> extrapolated(const Quantity& quantity, const Family& members, const Result& result,
                                   const Orders& orders) {
  if (!orders.space || !orders.time || orders.space->slope <= 0 || orders.time->slope <= 0)
    return std::nullopt;
  const Result *wider = nullptr, *longer = nullptr;
  for (const Result* other : members) {
    if (other->rung.steps == result.rung.steps && other->rung.size > result.rung.size &&
        (!wider || other->rung.size < wider->rung.size))
      wider = other;
    if (other->rung.size == result.rung.size && other->rung.steps < result.rung.steps &&
        (!longer || other->rung.steps > longer->rung.steps))
      longer = other;
  }
  if (!wider || !longer)
    return std::nullopt;
  const std::optional<double> space = distance_to(quantity, *wider->measured, *result.measured),
                              time = distance_to(quantity, *longer->measured, *result.measured);
  if (!space || !time)
    return std::nullopt;
  const auto part = [](double distance, double ratio, double slope) {
    return distance / (std::pow(ratio, slope) - 1);
  };
  return finite(part(*space, wider->rung.size / result.rung.size, orders.space->slope) +
                part(*time, static_cast<double>(result.rung.steps) / longer->rung.steps, orders.time->slope));
}

std::vector<bool> pareto_front(const std::vector<Result>& results,
                               const std::vector<std::optional<double>>& error) {
  std::vector<bool> front(results.size(), false);
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (!error[i])
      continue;
    front[i] = true;
    for (std::size_t j = 0; j < results.size() && front[i]; ++j)
      if (error[j] && results[j].measured->seconds < results[i].measured->seconds && *error[j] <= *error[i])
        front[i] = false;
  }
  return front;
}

} // namespace

Errors errors(const Quantity& quantity, const std::vector<Result>& results, const Exact& exact) {
  Errors found{quantity, exact.knows(quantity), {}, {}, {}, {}, {}};
  if (!found.exact)
    for (std::size_t i = 0; i < results.size(); ++i)
      if (results[i].measured && is_finite(quantity, *results[i].measured) &&
          (!found.reference || finer(results[i].rung, results[*found.reference].rung)))
        found.reference = i;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const std::optional<Measured>& run = results[i].measured;
    found.error.emplace_back();
    found.estimate.emplace_back();
    if (!run)
      continue;
    if (found.exact)
      found.error.back() = distance_to(quantity, *run, exact);
    else if (found.reference && i != *found.reference)
      found.error.back() = distance_to(quantity, *run, *results[*found.reference].measured);
    if (quantity.name == "J" && run->estimate && run->estimate->space)
      found.estimate.back() = relative(std::abs(run->estimate->sum()), std::abs(run->numbers.at("J")));
  }
  for (const Family& family : families(results)) {
    const Orders orders = orders_of(quantity, family, {});
    for (const Result* member : family)
      if (std::optional<double>& estimate = found.estimate[static_cast<std::size_t>(member - results.data())];
          !estimate)
        estimate = extrapolated(quantity, family, *member, orders);
  }
  constexpr double small = 1.0 / 3;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const std::optional<double> of_reference =
        found.reference ? found.estimate[*found.reference] : std::optional(0.0);
    found.effectivity.emplace_back();
    if (found.error[i] && found.estimate[i] && of_reference && *found.error[i] > 0 &&
        *of_reference <= small * *found.error[i])
      found.effectivity.back() = *found.estimate[i] / *found.error[i];
  }
  found.pareto = pareto_front(results, found.error);
  return found;
}

std::vector<Orders> orders(const Quantity& quantity, const std::vector<Result>& results, const Exact& exact) {
  std::vector<Orders> all;
  for (const Family& family : families(results))
    if (const Orders found = orders_of(quantity, family, exact); found.space || found.time || found.both)
      all.push_back(found);
  return all;
}

std::vector<std::string> sentences(const Errors& errors, const std::vector<Result>& results,
                                   const scene::Scene& scene) {
  std::vector<std::string> texts;
  std::optional<double> best;
  for (const std::optional<double>& error : errors.error)
    if (error && !(best && *best <= *error))
      best = error;
  if (!best)
    return texts;
  for (double target : {0.1, 0.01, 0.001}) {
    const Result* cheapest = nullptr;
    for (std::size_t i = 0; i < results.size(); ++i)
      if (errors.error[i] && *errors.error[i] <= target &&
          (!cheapest || results[i].measured->seconds < cheapest->measured->seconds))
        cheapest = &results[i];
    if (cheapest) {
      texts.push_back(fmt::format("for {} % in {}: {}, {:.2g} s", 100 * target, errors.quantity.title,
                                  words(cheapest->rung, scene), cheapest->measured->seconds));
    } else {
      texts.push_back(fmt::format("{} % in {} is out of this ladder's reach: its best is {:.2g} %",
                                  100 * target, errors.quantity.title, 100 * *best));
      break;
    }
  }
  return texts;
}

} // namespace signorini::study
