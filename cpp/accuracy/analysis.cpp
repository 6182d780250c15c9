// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/analysis.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

namespace signorini::accuracy {
namespace {

using Values = std::span<const double>;

double norm(Values x) {
  double sum = 0;
  for (double value : x)
    sum += value * value;
  return std::sqrt(sum);
}

double difference(Values a, Values b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

std::optional<double> finite(double value) {
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

/// Quotient difference / size: 0 if both are zero, absent if it is not finite.
std::optional<double> relative(double difference, double size) {
  return difference == 0 && size == 0 ? 0 : finite(difference / size);
}

/// Divisor of a quantity's errors: the norm of the known values; 1 for a quantity that is relative already.
double scale(const Quantity& quantity, Values known) { return quantity.already_relative ? 1 : norm(known); }

/// Distance between a quantity in a run and its known values, which are exact or those of another run,
/// divided by scale(); absent if it is not finite.
template <class Known>
std::optional<double> distance_to(const Quantity& quantity, const Measured& run, const Known& known) {
  const Values there = known.values(quantity);
  return relative(difference(run.values(quantity), there), scale(quantity, there));
}

bool is_finite(const Quantity& quantity, const Measured& run) {
  return std::isfinite(norm(run.values(quantity)));
}

bool finer(const Rung& a, const Rung& b) {
  return std::tuple(-a.size, -a.step_width(), a.degree) > std::tuple(-b.size, -b.step_width(), b.degree);
}

bool alike(const Rung& a, const Rung& b) {
  return a.degree == b.degree && a.scheme == b.scheme && a.has_varying_steps() == b.has_varying_steps() &&
         a.graded == b.graded;
}

/// Rungs that have run and have the same degree, scheme, kind of steps and kind of mesh, from coarse to fine.
using Family = std::vector<const RungResult*>;

std::vector<Family> families(const std::vector<RungResult>& results) {
  std::vector<Family> all;
  for (const RungResult& result : results) {
    if (!result.measured)
      continue;
    const auto own = std::ranges::find_if(
        all, [&](const Family& family) { return alike(family.front()->rung, result.rung); });
    (own == all.end() ? all.emplace_back() : *own).push_back(&result);
  }
  for (Family& family : all)
    std::ranges::sort(family,
                      [](const RungResult* a, const RungResult* b) { return finer(b->rung, a->rung); });
  return all;
}

/// Chains of values of a quantity over the rungs of a family: refined in space, in time, and in both; with
/// the limits for each chain.
struct Chains {
  Chain space, time, both;
  Limits in_space{}, in_time{}, in_both{};
};

/// Values of a quantity on those rungs of a family on which the quantity is finite, from coarse to fine.
/// Meshes of different size with equally many unknowns are equal, and count once.
Chain chain(const Quantity& quantity, const Family& members, double (*width)(const Rung&)) {
  Chain values;
  long unknowns = -1;
  double size = 0;
  for (const RungResult* member : members) {
    if (!is_finite(quantity, *member->measured))
      continue;
    const Value value{width(member->rung), member->measured->values(quantity)};
    const bool same = member->rung.size < size && member->measured->unknowns == unknowns;
    (same ? values.back() : values.emplace_back()) = value;
    unknowns = member->measured->unknowns;
    size = member->rung.size;
  }
  return values;
}

double size_of(const Rung& rung) { return rung.size; }
double step_of(const Rung& rung) { return rung.step_width(); }
bool same_steps(const Rung& a, const Rung& b) { return a.step_width() == b.step_width(); }

/// Chains that end at the rung `at`: over rungs with the same steps, over rungs with the same size, and over
/// rungs that refine both. The last chain is built backwards from `at`; each preceding rung has the next
/// coarser size and a longer step.
Chains chains(const Quantity& quantity, const Family& members, const Rung& at) {
  Family space, time, both;
  for (const RungResult* member : members) {
    if (same_steps(member->rung, at) && member->rung.size >= at.size)
      space.push_back(member);
    if (member->rung.size == at.size && step_of(member->rung) >= step_of(at))
      time.push_back(member);
  }
  const Rung* last = nullptr;
  for (auto member = members.rbegin(); member != members.rend(); ++member) {
    const Rung& rung = (*member)->rung;
    const bool next = !last ? same_steps(rung, at) && rung.size == at.size
                            : rung.size > last->size && step_of(rung) > step_of(*last);
    if (!next)
      continue;
    both.push_back(*member);
    last = &rung;
  }
  std::ranges::reverse(both);
  Chains found{chain(quantity, space, size_of), chain(quantity, time, step_of),
               chain(quantity, both, step_of)};
  const double by_size = highest_order_in_size(quantity, at.degree);
  found.in_space.order = by_size;
  found.in_time.order = found.in_both.order = highest_order_in_step;
  if (both.size() > 1) { // widths are steps, and sizes may have been refined by another factor
    const Rung &coarse = both.front()->rung, &fine = both.back()->rung;
    found.in_both.order = std::max(highest_order_in_step, by_size * std::log(coarse.size / fine.size) /
                                                              std::log(step_of(coarse) / step_of(fine)));
  }
  for (const auto& [limits, values] : {std::pair(&found.in_space, &found.space),
                                       {&found.in_time, &found.time},
                                       {&found.in_both, &found.both}})
    limits->rounding = values->empty() ? 0 : rounding * scale(quantity, values->back().samples);
  return found;
}

Orders orders_of(const Quantity& quantity, const Family& members, const Exact& exact) {
  Rung finest = members.back()->rung;
  for (const RungResult* member : members)
    if (step_of(member->rung) < step_of(finest))
      finest.steps = member->rung.steps, finest.tolerance = member->rung.tolerance;
  const Chains along = chains(quantity, members, finest);
  // Errors against exact values would stagnate, in space or time alone, at the error of the other kind.
  return {quantity.name,
          finest.degree,
          finest.scheme,
          finest.has_varying_steps(),
          finest.graded,
          observed_order(along.space, along.in_space),
          observed_order(along.time, along.in_time),
          exact.knows(quantity) ? observed_order(along.both, exact.values(quantity), along.in_both)
                                : observed_order(along.both, along.in_both)};
}

/// Estimates the error of a run by Richardson extrapolation, from the differences to the next coarser runs in
/// size and in step; absent unless the observed orders are in the asymptotic range.
std::optional<double> extrapolated(const Quantity& quantity, const Family& members, const RungResult& result,
                                   const Orders& orders) {
  if (!orders.space || !orders.time || !orders.space->asymptotic || !orders.time->asymptotic)
    return std::nullopt;
  const RungResult *wider = nullptr, *longer = nullptr;
  for (const RungResult* other : members) {
    if (same_steps(other->rung, result.rung) && other->rung.size > result.rung.size &&
        (!wider || other->rung.size < wider->rung.size))
      wider = other;
    if (other->rung.size == result.rung.size && step_of(other->rung) > step_of(result.rung) &&
        (!longer || step_of(other->rung) < step_of(longer->rung)))
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
                part(*time, step_of(longer->rung) / step_of(result.rung), orders.time->slope));
}

/// Whether a part of an error bar is absent, explained by rounding, or from values in the asymptotic range.
bool in_range(const Chain& values, const Limits& limits, const std::optional<double>& bar) {
  constexpr double factor = 10; // includes the bar's own factor
  if (!bar || *bar <= factor * rounding)
    return true;
  const std::optional<Order> order = observed_order(values, limits);
  return order && order->asymptotic;
}

std::optional<ReferenceBar> reference_bar(const Quantity& quantity, const Family& members,
                                          const RungResult& reference) {
  const Measured& run = *reference.measured;
  const Chains along = chains(quantity, members, reference.rung);
  const double whole = scale(quantity, run.values(quantity));
  const auto part = [&](const Chain& values, const Limits& limits) {
    const std::optional<double> bar = error_bar(values, limits);
    return bar ? relative(*bar, whole) : std::nullopt;
  };
  ReferenceBar bar;
  bar.size = part(along.space, along.in_space);
  bar.step = part(along.time, along.in_time);
  bar.value = bar.size.value_or(0) + bar.step.value_or(0);
  bar.asymptotic =
      in_range(along.space, along.in_space, bar.size) && in_range(along.time, along.in_time, bar.step);
  if (quantity.name == "J" && run.estimate && run.estimate->space) {
    if (const std::optional<double> adjoint = relative(cautious_bound(*run.estimate), whole)) {
      bar.adjoint = true;
      bar.value = std::max(bar.value, *adjoint);
    }
  }
  return bar.size || bar.step || bar.adjoint ? std::optional(bar) : std::nullopt;
}

std::vector<std::optional<double>> envelopes(const Errors& errors, const std::vector<RungResult>& results) {
  std::vector<std::optional<double>> all = errors.error;
  for (std::size_t i = 0; i < results.size(); ++i)
    for (std::size_t j = 0; j < results.size() && all[i]; ++j) {
      const Rung &coarse = results[i].rung, &fine = results[j].rung;
      if (j == errors.reference || !results[j].measured || !alike(coarse, fine) || fine.size > coarse.size ||
          step_of(fine) > step_of(coarse))
        continue;
      all[i] = errors.error[j] ? std::optional(std::max(*all[i], *errors.error[j])) : std::nullopt;
    }
  return all;
}

std::vector<bool> pareto_front(const std::vector<RungResult>& results,
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

/// Number of the finest rung on which a quantity is finite. For each kind of steps and of mesh, the finest
/// rung has the smallest size, then the most steps or the smallest tolerance. Kinds cannot be compared by
/// size and step: among the finest rungs of all kinds, at the smallest size, the one with the smallest error
/// bar counts if all have one, else the one with most steps.
std::optional<std::size_t> finest(const Quantity& quantity, const std::vector<RungResult>& results) {
  std::vector<std::size_t> found; // the finest of each kind
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (!results[i].measured || !is_finite(quantity, *results[i].measured))
      continue;
    const auto own = std::ranges::find_if(found, [&](std::size_t other) {
      const Rung &a = results[i].rung, &b = results[other].rung;
      return a.has_varying_steps() == b.has_varying_steps() && a.graded == b.graded;
    });
    if (own == found.end())
      found.push_back(i);
    else if (finer(results[i].rung, results[*own].rung))
      *own = i;
  }
  if (found.empty())
    return std::nullopt;
  const double least =
      results[std::ranges::min(found, {}, [&](std::size_t i) { return results[i].rung.size; })].rung.size;
  std::erase_if(found, [&](std::size_t i) { return results[i].rung.size > least; });
  const std::vector<Family> all = families(results);
  std::vector<double> bars;
  for (const std::size_t i : found) {
    const auto own = std::ranges::find_if(
        all, [&](const Family& family) { return alike(family.front()->rung, results[i].rung); });
    if (const std::optional<ReferenceBar> bar = reference_bar(quantity, *own, results[i]))
      bars.push_back(bar->value);
  }
  if (bars.size() == found.size())
    return found[static_cast<std::size_t>(std::ranges::min_element(bars) - bars.begin())];
  return std::ranges::max(found, {}, [&](std::size_t i) { return results[i].measured->steps; });
}

} // namespace

double cautious_bound(const adjoint::ErrorParts& estimate) {
  constexpr double underestimated = 2;
  return std::max(underestimated * std::abs(estimate.sum()), estimate.sum_of_moduli());
}

std::optional<double> distance(const Quantity& quantity, const Measured& run, const Measured& known) {
  return distance_to(quantity, run, known);
}

double highest_order_in_size(const Quantity& quantity, int degree) {
  return quantity.field ? degree + 1 : 2 * degree;
}

Errors errors(const Quantity& quantity, const std::vector<RungResult>& results, const Exact& exact) {
  Errors found;
  found.quantity = quantity;
  found.exact = exact.knows(quantity);
  if (!found.exact)
    found.reference = finest(quantity, results);
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
    for (const RungResult* member : family) {
      const auto i = static_cast<std::size_t>(member - results.data());
      if (!found.estimate[i])
        found.estimate[i] = extrapolated(quantity, family, *member, orders);
      if (i == found.reference)
        found.bar = reference_bar(quantity, family, *member);
    }
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
  found.envelope = envelopes(found, results);
  found.pareto = pareto_front(results, found.envelope);
  return found;
}

std::vector<Orders> orders(const Quantity& quantity, const std::vector<RungResult>& results,
                           const Exact& exact) {
  std::vector<Orders> all;
  for (const Family& family : families(results))
    if (const Orders found = orders_of(quantity, family, exact); found.space || found.time || found.both)
      all.push_back(found);
  return all;
}

} // namespace signorini::accuracy
