// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/text.h"
#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <numeric>
#include <span>

namespace signorini {

std::string point_text(const double* x, int dim) {
  return fmt::format("({:.6g})", fmt::join(std::span(x, static_cast<std::size_t>(dim)), ", "));
}

std::string bytes_text(double bytes) {
  constexpr double kilo = 1e3, mega = 1e6, giga = 1e9;
  return bytes >= giga   ? fmt::format("{:.3g} GB", bytes / giga)
         : bytes >= mega ? fmt::format("{:.3g} MB", bytes / mega)
                         : fmt::format("{:.3g} kB", bytes / kilo);
}

std::string list(const std::vector<std::string>& names) { return fmt::format("{}", fmt::join(names, ", ")); }

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({change, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

std::string nearest(std::string_view found, const std::vector<std::string>& valid) {
  std::string best;
  std::size_t least = std::max<std::size_t>(2, found.size() / 2) + 1;
  for (const std::string& name : valid)
    if (const std::size_t d = edit_distance(found, name); d < least)
      least = d, best = name;
  return best;
}

std::string suggestion(std::string_view found, const std::vector<std::string>& valid) {
  const std::string near = nearest(found, valid);
  return near.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", near);
}

} // namespace signorini
