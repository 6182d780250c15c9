// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/time_series.h"
#include "base/error.h"
#include "scene/names.h"
#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <optional>
#include <sstream>
#include <string_view>

namespace signorini::scene {
namespace {

/// A cell without blanks and quotes around it.
std::string_view bare(std::string_view cell) {
  constexpr std::string_view around = " \t\r\"";
  const std::size_t first = cell.find_first_not_of(around);
  return first == std::string_view::npos ? std::string_view()
                                         : cell.substr(first, cell.find_last_not_of(around) - first + 1);
}

std::vector<std::string_view> cells(std::string_view line, char separator) {
  std::vector<std::string_view> found;
  for (std::size_t end = 0; end != std::string_view::npos; line.remove_prefix(std::min(end + 1, line.size())))
    end = line.find(separator), found.push_back(bare(line.substr(0, end)));
  return found;
}

/// The separator that the line of names has, in the order in which others may stand in names.
char separator(std::string_view names) {
  for (char c : {'\t', ';'})
    if (names.find(c) != std::string_view::npos)
      return c;
  return ',';
}

std::optional<double> number(std::string_view text) {
  if (text.starts_with('+'))
    text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(value)
             ? std::optional(value)
             : std::nullopt;
}

/// Columns of the times and of a quantity.
struct Columns {
  std::size_t time = 0, value = 0;

  Columns(const std::vector<std::string_view>& names, const std::string& column) {
    const auto place = [&](std::string_view name) {
      return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
    };
    for (const char* name : {"t", "time"})
      if (place(name) < names.size())
        time = place(name);
    value = place(column);
    if (value < names.size())
      return;
    const std::vector<std::string> known(names.begin(), names.end());
    const std::string near = nearest(column, known);
    throw UserError(fmt::format("found no column \"{}\"{}, allowed: {}", column,
                                near.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", near),
                                list(known)));
  }
};

} // namespace

std::string read_file(const std::filesystem::path& file) {
  std::error_code none;
  std::ifstream in;
  if (std::filesystem::is_regular_file(file, none)) // others may never end
    in.open(file, std::ios::binary);
  std::ostringstream text;
  if (!in.is_open() || !(text << in.rdbuf()))
    throw UserError(fmt::format("{}: cannot be read, allowed is a file that is not empty", file.string()));
  return text.str();
}

TimeSeries::TimeSeries(const std::string& text, const std::string& column) {
  std::optional<Columns> columns;
  char between = ',';
  int number_of_line = 0;
  std::string_view left = text;
  if (left.starts_with("\xef\xbb\xbf")) // the mark by which some programs begin UTF-8
    left.remove_prefix(3);
  while (!left.empty()) {
    const std::string_view line = left.substr(0, left.find('\n'));
    left.remove_prefix(std::min(line.size() + 1, left.size()));
    ++number_of_line;
    if (bare(line).empty() || line.starts_with('#'))
      continue;
    if (!columns) {
      between = separator(line);
      columns.emplace(cells(line, between), column);
      continue;
    }
    const std::vector<std::string_view> row = cells(line, between);
    const auto at = [&](std::size_t i) {
      const std::string_view cell = i < row.size() ? row[i] : std::string_view();
      const std::optional<double> value = number(cell);
      if (!value)
        throw UserError(fmt::format("line {}: found \"{}\" in column {}, allowed is a number with a decimal "
                                    "point",
                                    number_of_line, cell.substr(0, 40), i + 1));
      return *value;
    };
    add(at(columns->time), at(columns->value), number_of_line);
  }
  if (times_.size() < 2)
    throw UserError(fmt::format("found {} line{} of numbers, allowed are two and more behind one of names",
                                times_.size(), times_.size() == 1 ? "" : "s"));
}

bool TimeSeries::has_column(const std::string& text, const std::string& column) {
  for (std::string_view left = text; !left.empty();) {
    const std::string_view line = left.substr(0, left.find('\n'));
    left.remove_prefix(std::min(line.size() + 1, left.size()));
    if (!bare(line).empty() && !line.starts_with('#'))
      return std::ranges::count(cells(line, separator(line)), column) > 0;
  }
  return false;
}

void TimeSeries::add(double time, double value, int line) {
  if (!times_.empty() && !(time > times_.back()))
    throw UserError(fmt::format("line {}: found the time {} s behind {} s, allowed are times that ascend",
                                line, time, times_.back()));
  times_.push_back(time);
  values_.push_back(value);
}

double TimeSeries::operator()(double t) const {
  const auto above = std::ranges::upper_bound(times_, t);
  if (above == times_.begin())
    return values_.front();
  if (above == times_.end())
    return values_.back();
  const auto i = static_cast<std::size_t>(above - times_.begin());
  const double weight = (t - times_[i - 1]) / (times_[i] - times_[i - 1]);
  return values_[i - 1] + weight * (values_[i] - values_[i - 1]);
}

double TimeSeries::slope(double t, bool after) const {
  // Times of steps are sums, and a hair beside the table's.
  const double hair = 1e-9 * (end() - begin()) / static_cast<double>(times_.size() - 1);
  const auto above = std::ranges::upper_bound(times_, after ? t + hair : t - hair);
  if (above == times_.begin() || above == times_.end())
    return 0;
  const auto i = static_cast<std::size_t>(above - times_.begin());
  return (values_[i] - values_[i - 1]) / (times_[i] - times_[i - 1]);
}

} // namespace signorini::scene
