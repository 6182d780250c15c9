// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/convergence.h"
#include <algorithm>
#include <cmath>
#include <numeric>

namespace signorini::accuracy {
namespace {

using Values = std::span<const double>;

/// Scalar product (b − a)·(d − c).
double product(Values a, Values b, Values c, Values d) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += (b[i] - a[i]) * (d[i] - c[i]);
  return sum;
}

double distance(Values a, Values b) { return std::sqrt(product(a, b, a, b)); }

/// Largest modulus of observed orders.
constexpr double highest_order = 20;

/// Order p for which widths h1 > h2 > h3 give `ratio`, the second difference of values over the first.
double order_of_differences(double h1, double h2, double h3, double ratio) {
  const double coarse = std::log(h1 / h2), fine = std::log(h2 / h3);
  const auto log_ratio = [&](double p) { // falls with p
    return p == 0 ? std::log(fine / coarse) : std::log(-std::expm1(-p * fine) / std::expm1(p * coarse));
  };
  double low = -highest_order, high = highest_order;
  constexpr int halvings = 60; // to rounding
  for (int i = 0; i < halvings; ++i) {
    const double middle = (low + high) / 2;
    (log_ratio(middle) > std::log(ratio) ? low : high) = middle;
  }
  return (low + high) / 2;
}

/// Order of neighbouring values, and whether these are in the asymptotic range.
struct Local {
  double p;
  bool holds;
};

Local judged(double p, bool same_way, const Limits& limits) {
  constexpr double least = 0.25, scatter = 0.5;
  p = std::clamp(p, -highest_order, highest_order);
  return {p, same_way && p >= least && p <= limits.order + scatter};
}

/// Order of three successive values, and whether these are in the asymptotic range.
Local local(const Value& a, const Value& b, const Value& c, const Limits& limits) {
  const double ratio = distance(b.samples, c.samples) / distance(a.samples, b.samples);
  return judged(order_of_differences(a.width, b.width, c.width, ratio),
                product(a.samples, b.samples, b.samples, c.samples) > 0, limits);
}

std::optional<Order> summary(const std::vector<Local>& locals) {
  if (locals.empty())
    return std::nullopt;
  const auto fails =
      std::find_if(locals.rbegin(), locals.rend(), [](const Local& one) { return !one.holds; });
  const bool asymptotic = fails != locals.rbegin();
  const std::vector<Local> used(asymptotic ? fails.base() : locals.begin(), locals.end());
  const auto [least, largest] = std::ranges::minmax(used, {}, &Local::p);
  const double sum = std::accumulate(used.begin(), used.end(), 0.0,
                                     [](double before, const Local& one) { return before + one.p; });
  return Order{sum / static_cast<double>(used.size()), least.p, largest.p, asymptotic};
}

/// Largest distance between any two values.
double spread(std::span<const Value> values) {
  double largest = 0;
  for (const Value& a : values)
    for (const Value& b : values)
      largest = std::max(largest, distance(a.samples, b.samples));
  return largest;
}

} // namespace

std::optional<Order> observed_order(const Chain& chain, const Limits& limits) {
  std::size_t size = chain.size();
  while (size > 1 && !(distance(chain[size - 2].samples, chain[size - 1].samples) > limits.rounding))
    --size;
  std::vector<Local> locals;
  for (std::size_t i = 2; i < size; ++i)
    locals.push_back(local(chain[i - 2], chain[i - 1], chain[i], limits));
  return summary(locals);
}

std::optional<Order> observed_order(const Chain& chain, std::span<const double> exact, const Limits& limits) {
  std::size_t size = chain.size();
  while (size > 0 && !(distance(chain[size - 1].samples, exact) > limits.rounding))
    --size;
  std::vector<Local> locals;
  for (std::size_t i = 1; i < size; ++i) {
    const Value &a = chain[i - 1], &b = chain[i];
    const double p =
        std::log(distance(a.samples, exact) / distance(b.samples, exact)) / std::log(a.width / b.width);
    locals.push_back(judged(p, product(exact, a.samples, exact, b.samples) > 0, limits));
  }
  return summary(locals);
}

std::optional<double> error_bar(const Chain& chain, const Limits& limits) {
  constexpr double careful = 3, confident = 2;
  if (chain.size() < 2)
    return std::nullopt;
  const std::span<const Value> last = std::span(chain).last(std::min<std::size_t>(chain.size(), 3));
  if (last.size() == 3)
    if (const Local found = local(last[0], last[1], last[2], limits); found.holds) {
      const double p = std::min(found.p, limits.order);
      return confident * distance(last[1].samples, last[2].samples) /
             std::expm1(p * std::log(last[1].width / last[2].width));
    }
  return careful * spread(last);
}

} // namespace signorini::accuracy
