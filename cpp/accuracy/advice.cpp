// SPDX-License-Identifier: GPL-3.0-or-later
#include "accuracy/analysis.h"
#include <algorithm>
#include <fmt/format.h>

namespace signorini::accuracy {
namespace {

/// What a recommendation rests on.
std::string grounds(const Errors& errors, double envelope) {
  std::string text = fmt::format("off by at most {} there and at all finer rungs", percent(envelope));
  if (errors.bar)
    text += fmt::format("; finest rung: {}", words(*errors.bar));
  return text;
}

/// The rung with the smallest envelope, the cheapest of those within a tolerance that no warning puts in
/// warning, and the cheapest of the others.
struct Best {
  std::optional<std::size_t> nearest, cheapest, warned;
};

Best best(const Errors& errors, const std::vector<Result>& results, double tolerance) {
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
    if (!cheapest || results[i].measured->seconds < results[*cheapest].measured->seconds)
      cheapest = i;
  }
  return found;
}

} // namespace

std::string percent(double value, int digits) { return fmt::format("{:.{}g} %", 100 * value, digits); }

std::string words(const ReferenceBar& bar) {
  std::string text = fmt::format("error bar {}", percent(bar.value));
  if (!bar.adjoint && !(bar.size && bar.step))
    text += bar.size ? " of the size alone, steps not verified" : " of the step alone, sizes not verified";
  return bar.asymptotic ? text : text + ", not in the asymptotic range";
}

std::vector<std::string> sentences(const Errors& errors, const std::vector<Result>& results,
                                   const scene::Scene& scene) {
  const std::string& title = errors.quantity.title;
  if (std::ranges::none_of(errors.error, [](const auto& error) { return error.has_value(); }))
    return {};
  if (!best(errors, results, 0).nearest)
    return {fmt::format("nothing is recommended for {}: finer rungs have no number", title)};
  if (!errors.exact && !errors.bar)
    return {fmt::format(
        "nothing is recommended for {}: nothing tells how far the finest rung is off, which takes "
        "a second size or step",
        title)};
  const double bar = errors.bar ? errors.bar->value : 0;
  std::vector<std::string> texts;
  for (double target : {0.1, 0.05, 0.01, 0.001}) {
    const auto [nearest, cheapest, warned] = best(errors, results, target - bar);
    if (cheapest) {
      texts.push_back(fmt::format("for {} % in {}: {}, {:.2g} s ({})", 100 * target, title,
                                  words(results[*cheapest].rung, scene), results[*cheapest].measured->seconds,
                                  grounds(errors, *errors.envelope[*cheapest])));
      continue;
    }
    if (warned) {
      texts.push_back(fmt::format("{} % in {} is not verified: {} ({}), but {}", 100 * target, title,
                                  words(results[*warned].rung, scene),
                                  grounds(errors, *errors.envelope[*warned]),
                                  results[*warned].measured->warning(errors.quantity)));
      continue;
    }
    const double reach = *errors.envelope[*nearest] + bar;
    texts.push_back(fmt::format("{} % in {} is out of this ladder's reach: its best is {}{}", 100 * target,
                                title, percent(reach),
                                errors.bar ? fmt::format(" (finest rung: {})", words(*errors.bar)) : ""));
    break;
  }
  return texts;
}

} // namespace signorini::accuracy
