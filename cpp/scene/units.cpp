// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/units.h"
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <utility>

namespace signorini::scene {
namespace {

constexpr std::pair<std::string_view, Unit> symbols[] = {
    {"m", {1, {1, 0, 0}}},    {"g", {1e-3, {0, 1, 0}}}, {"s", {1, {0, 0, 1}}},   {"min", {60, {0, 0, 1}}},
    {"h", {3600, {0, 0, 1}}}, {"N", {1, {1, 1, -2}}},   {"Pa", {1, {-1, 1, -2}}}};

// Programs for laboratories write µ, ² and ³ in UTF-8 or, in one byte each, in Latin-1.
constexpr std::pair<std::string_view, double> prefixes[] = {
    {"n", 1e-9}, {"u", 1e-6}, {"\u00b5", 1e-6}, {"\xb5", 1e-6}, {"\u03bc", 1e-6}, {"m", 1e-3},
    {"c", 1e-2}, {"d", 1e-1}, {"k", 1e3},       {"M", 1e6},     {"G", 1e9}};

std::optional<Unit> symbol(std::string_view text) {
  for (const auto& [name, one] : symbols)
    if (text == name)
      return one;
  for (const auto& [prefix, factor] : prefixes)
    for (const auto& [name, one] : symbols)
      if (name != "min" && name != "h" && text.starts_with(prefix) && text.substr(prefix.size()) == name)
        return Unit{factor * one.factor, one.dimension};
  return std::nullopt;
}

/// Removes the exponent from the end of a factor such as mm² or s^2, and returns it; 1 if there is none,
/// absent if it is not valid.
std::optional<int> take_exponent(std::string_view& factor) {
  for (const auto& [text, exponent] :
       {std::pair<std::string_view, int>{"\u00b2", 2}, {"\u00b3", 3}, {"\xb2", 2}, {"\xb3", 3}})
    if (factor.ends_with(text)) {
      factor.remove_suffix(text.size());
      return exponent;
    }
  const std::size_t first = factor.find_first_of("^-0123456789");
  if (first == std::string_view::npos)
    return 1;
  std::string_view digits = factor.substr(first);
  factor = factor.substr(0, first);
  if (digits.starts_with('^'))
    digits.remove_prefix(1);
  int exponent = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), exponent);
  return error == std::errc() && end == digits.data() + digits.size() && std::abs(exponent) <= 9
             ? std::optional(exponent)
             : std::nullopt;
}

} // namespace

std::optional<Unit> unit(std::string_view text) {
  constexpr std::string_view times[] = {"*", "\u00b7", " "};
  Unit product;
  bool any = false, over = false; // over: behind the solidus, of which one is allowed
  const auto next = [&] {
    std::size_t end = text.find('/');
    for (const std::string_view sign : times)
      end = std::min(end, text.find(sign));
    return end;
  };
  const auto skip = [&] {
    for (bool found = true; found;) {
      found = false;
      for (const std::string_view sign : times)
        if (text.starts_with(sign))
          text.remove_prefix(sign.size()), found = true;
    }
  };
  for (skip(); !text.empty(); skip()) {
    if (text.starts_with('/')) {
      if (over || !any)
        return std::nullopt;
      over = true;
      text.remove_prefix(1);
      any = false; // something must follow
      continue;
    }
    std::string_view factor = text.substr(0, next());
    text.remove_prefix(factor.size());
    any = true;
    if (factor == "1" && !over)
      continue;
    const std::optional<int> exponent = take_exponent(factor);
    const std::optional<Unit> one = exponent ? symbol(factor) : std::nullopt;
    if (!one)
      return std::nullopt;
    const int power = over ? -*exponent : *exponent;
    product.factor *= std::pow(one->factor, power);
    for (std::size_t i = 0; i < product.dimension.size(); ++i)
      product.dimension[i] += power * one->dimension[i];
  }
  return any ? std::optional(product) : std::nullopt;
}

bool Limits::contain(double value) const {
  return std::isfinite(value) &&
         (open ? value > least && value < greatest : value >= least && value <= greatest);
}

std::string Limits::range() const {
  std::string range;
  if (std::isfinite(least))
    range += fmt::format(" {} {}", open ? "greater than" : "of at least", least);
  if (std::isfinite(greatest))
    range += fmt::format("{} {} {}", range.empty() ? "" : " and", open ? "less than" : "at most", greatest);
  return range;
}

} // namespace signorini::scene
