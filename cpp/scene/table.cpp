// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/table.h"
#include "base/error.h"
#include "base/text.h"
#include "scene/csv.h"
#include "scene/schema.h"
#include "scene/units.h"
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <optional>
#include <string_view>
#include <toml++/toml.hpp>

namespace signorini::scene {
namespace {

constexpr std::size_t shown = 40; ///< largest number of bytes of a cell in a message

using csv::trimmed, csv::cells, csv::separator, csv::for_each_line, csv::require_bytes_of_text;

std::optional<double> number(std::string_view text) {
  if (text.starts_with('+'))
    text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(value)
             ? std::optional(value)
             : std::nullopt;
}

/// Name of a column such as "x [mm]" or "x (mm)", split into base name and unit.
struct Name {
  std::string_view base, unit; ///< text before the brackets, and text inside; unit empty without brackets
  bool square = false;

  explicit Name(std::string_view whole) : base(whole) {
    square = whole.ends_with(']');
    if (!square && !whole.ends_with(')'))
      return;
    const std::size_t open = whole.rfind(square ? '[' : '(');
    if (open == std::string_view::npos || open == 0)
      return;
    base = trimmed(whole.substr(0, open));
    unit = trimmed(whole.substr(open + 1, whole.size() - open - 2));
  }
};

bool is_time(std::string_view name) {
  constexpr std::string_view time = "time";
  return std::ranges::equal(name, time, {}, [](unsigned char c) { return std::tolower(c); });
}
bool is_t(std::string_view name) { return name == "t"; }

/// Position of a column in a table, and the conversion of its values.
struct Column {
  std::size_t place = 0; ///< index of the column
  double factor = 1;     ///< SI units per unit of the column
  bool whole = true;     ///< whether the column was found by its whole name, so that no unit is applied
};

/// Index of the only name for which `matches` is true; absent if there is none. Throws UserError if there are
/// several.
template <class Matches>
std::optional<std::size_t> only(const std::vector<std::string_view>& names, Matches&& matches) {
  const auto first = std::ranges::find_if(names, matches);
  if (first == names.end())
    return std::nullopt;
  if (const auto other = std::find_if(first + 1, names.end(), matches); other != names.end())
    throw UserError(
        fmt::format("found \"{}\" in column {} and \"{}\" in column {}; rename all but the column to be used",
                    *first, first - names.begin() + 1, *other, other - names.begin() + 1));
  return static_cast<std::size_t>(first - names.begin());
}

/// Throws UserError unless the unit `found` has the dimension of one of the `allowed` units; accepts any unit
/// if `allowed` is empty. `name`: name of the column, for messages.
void require_unit(std::string_view name, const Unit& found, const std::vector<std::string>& allowed) {
  if (!allowed.empty() && std::ranges::none_of(allowed, [&](const std::string& one) {
        return unit(one).value_or(Unit{}).dimension == found.dimension;
      }))
    throw UserError(fmt::format("found the unit of column \"{}\", which cannot be converted to {}", name,
                                fmt::join(allowed, " or ")));
}

/// Finds the column of a quantity: the one named `column`, else the one named `column` before a unit.
/// `units`: units to which the column's unit must be convertible; empty: any. Throws UserError.
Column quantity_of(const std::vector<std::string_view>& names, const std::string& column,
                   const std::vector<std::string>& units) {
  if (const auto place = only(names, [&](std::string_view name) { return name == column; }))
    return {.place = *place};
  const auto place = only(names, [&](std::string_view name) {
    const Name parts(name);
    return parts.base == column && (parts.square || unit(parts.unit));
  });
  if (!place) {
    const std::vector<std::string> known(names.begin(), names.end());
    throw UserError(
        fmt::format("found no column \"{}\"{}; columns: {}", column, suggestion(column, known), list(known)));
  }
  const std::optional<Unit> found = unit(Name(names[*place]).unit);
  if (!found)
    throw UserError(fmt::format("found an unknown unit in \"{}\"; units combine m, g, s, min, h, N, Pa and "
                                "prefixes, as [kN] or [m/s^2]. To read it unconverted, set column to \"{}\"",
                                names[*place], names[*place]));
  require_unit(names[*place], *found, units);
  return {*place, found->factor, false};
}

/// Throws UserError if the line of column names consists of numbers, or of a single name other than `column`.
void require_names(const std::vector<std::string_view>& names, const std::string& column, int line) {
  constexpr const char* rule = "column names must be in the first line that does not begin with #";
  if (std::ranges::all_of(names, [](std::string_view name) { return number(name).has_value(); }))
    throw UserError(fmt::format("line {}: found numbers; {}", line, rule));
  if (names.size() == 1 && Name(names[0]).base != column)
    throw UserError(fmt::format("line {}: found \"{}\"; {}, separated by commas, semicolons or tabs", line,
                                names[0].substr(0, shown), rule));
}

/// Finds the column of times: "time" or "t", with or without a unit, else the first column. Throws UserError
/// if its unit is not a unit of time.
Column times_of(const std::vector<std::string_view>& names) {
  std::optional<std::size_t> place;
  for (bool (*const named)(std::string_view) : {is_time, is_t}) {
    if (!place)
      place = only(names, named);
    if (!place)
      place = only(names, [named](std::string_view name) { return named(Name(name).base); });
  }
  const std::string_view name = names[place.value_or(0)];
  const Name parts(name);
  const std::optional<Unit> found = unit(parts.unit);
  if (parts.unit.empty() || (!parts.square && !found))
    return {.place = place.value_or(0)};
  if (!found || found->dimension != unit("s")->dimension)
    throw UserError(
        fmt::format("found times in the unit of \"{}\"; expected a unit of time, as in \"time [ms]\"", name));
  return {place.value_or(0), found->factor, false};
}

} // namespace

TableColumn read_column(const std::string& text, const std::string& column,
                        const std::vector<std::string>& units) {
  require_bytes_of_text(text);
  TableColumn found;
  std::size_t columns = 0;
  Column time, quantity;
  char between = ',';
  for_each_line(text, [&](std::string_view line, int number_of_line) {
    if (columns == 0) {
      between = separator(line);
      const std::vector<std::string_view> names = cells(line, between);
      columns = names.size();
      require_names(names, column, number_of_line);
      quantity = quantity_of(names, column, units);
      time = times_of(names);
      found.name = names[quantity.place];
      found.factor = quantity.factor;
      if (const std::string_view base = Name(names[time.place]).base;
          time.place == quantity.place && !is_time(base) && !is_t(base))
        throw UserError(fmt::format("found no column of times beside \"{}\"; name it \"time\"", column));
      if (time.whole)
        found.time_name = names[time.place];
      if (const auto given = unit(Name(column).unit); quantity.whole && given && given->factor != 1)
        found.unconverted = column;
      return true;
    }
    const std::vector<std::string_view> row = cells(line, between);
    if (const auto extra = std::ranges::find_if(row.begin() + std::min(columns, row.size()), row.end(),
                                                [](std::string_view cell) { return !cell.empty(); });
        extra != row.end())
      throw UserError(fmt::format("line {}: found {} cells below {} column names; numbers need a decimal "
                                  "point and no thousands separators",
                                  number_of_line, row.size(), columns));
    const auto at = [&](std::size_t i) {
      const std::string_view cell = i < row.size() ? row[i] : std::string_view();
      const std::optional<double> value = number(cell);
      if (!value)
        throw UserError(
            fmt::format("line {}: found \"{}\" in column {}; expected a number with a decimal point",
                        number_of_line, cell.substr(0, shown), i + 1));
      return *value;
    };
    const double t = time.factor * at(time.place);
    if (!found.times.empty() && !(t > found.times.back()))
      throw UserError(fmt::format("line {}: found the time {} s after {} s; times must ascend",
                                  number_of_line, t, found.times.back()));
    found.times.push_back(t);
    found.values.push_back(quantity.factor * at(quantity.place));
    return true;
  });
  if (found.times.size() < 2)
    throw UserError(fmt::format("found {} line{} of numbers; expected at least two, after a line of column "
                                "names",
                                found.times.size(), found.times.size() == 1 ? "" : "s"));
  return found;
}

bool has_column(const std::string& text, const std::string& column) {
  bool found = false;
  for_each_line(text, [&](std::string_view line, int) {
    for (const std::string_view name : cells(line, separator(line)))
      found = found || name == column || (Name(name).base == column && unit(Name(name).unit));
    return false;
  });
  return found;
}

std::string unit_hint(const TableColumn& column) {
  return column.time_name.empty()
             ? ""
             : fmt::format("; times without a unit are in s, those of a column \"{} [ms]\" are converted",
                           column.time_name);
}

namespace {

/// Largest plausible ratio of the time span of a table to that of a run. Reading ms as s gives 1000; the
/// limit is slightly lower because of rounding.
constexpr double plausible_ratio = 999;

std::vector<TableWarning> doubt_about_the_unit(const TableColumn& column) {
  if (column.unconverted.empty())
    return {};
  const double factor = unit(Name(column.unconverted).unit)->factor;
  return {
      {fmt::format(
           "the values of column \"{}\" are taken as SI, unconverted; to convert them, set column = \"{}\"",
           column.unconverted, Name(column.unconverted).base),
       std::max(factor, 1 / factor), 1}};
}

} // namespace

std::vector<TableWarning> input_warnings(const TableColumn& column, double end) {
  const std::vector<double>& times = column.times;
  std::vector<TableWarning> warnings = doubt_about_the_unit(column);
  const double hair = 1e-9 * end, intervals = static_cast<double>(times.size() - 1);
  const auto used = std::ranges::lower_bound(times, end - hair) - (std::ranges::upper_bound(times, hair) - 1);
  if (used == 1 && intervals > 1)
    warnings.push_back(
        {fmt::format("the run, from 0 to {:.6g} s, uses one of {} intervals of the table, whose times "
                     "range from {:.6g} to {:.6g} s{}",
                     end, intervals, times.front(), times.back(), unit_hint(column)),
         intervals, 1});
  else if (!column.time_name.empty() && times.back() - times.front() > plausible_ratio * end)
    warnings.push_back(
        {fmt::format("the run, from 0 to {:.6g} s, uses at most a thousandth of the table, whose "
                     "times range from {:.6g} to {:.6g} s{}",
                     end, times.front(), times.back(), unit_hint(column)),
         (times.back() - times.front()) / end, plausible_ratio});
  return warnings;
}

std::vector<TableWarning> data_warnings(const TableColumn& column, double end) {
  const std::vector<double>& times = column.times;
  std::vector<TableWarning> warnings = doubt_about_the_unit(column);
  const double span = times.back() - times.front(), rest = end - times.back();
  double longest = 0;
  for (std::size_t i = 1; i < times.size(); ++i)
    longest = std::max(longest, times[i] - times[i - 1]);
  if (!column.time_name.empty() && span < end / plausible_ratio)
    warnings.push_back({fmt::format("the times span {:.3g} s, a thousandth of the run's {:.6g} s or less{}",
                                    span, end, unit_hint(column)),
                        end / span, plausible_ratio});
  else if (constexpr double rounding = 1e-9; rest > longest + rounding * end)
    warnings.push_back(
        {fmt::format("the data end at {:.6g} s, but the run at {:.6g} s: the rest of the run is not compared "
                     "with data",
                     times.back(), end),
         rest / longest, 1});
  return warnings;
}

namespace {

void find_series(const toml::node& node, const std::string& key, std::vector<NamedSeries>& found) {
  if (const toml::array* array = node.as_array()) {
    const bool tables = array->is_array_of_tables() && array->size() > 1;
    for (std::size_t i = 0; i < array->size(); ++i)
      find_series((*array)[i], tables ? fmt::format("{}[{}]", key, i) : key, found);
  }
  const toml::table* table = node.as_table();
  if (!table)
    return;
  const auto file = (*table)["file"].value<std::string>(), column = (*table)["column"].value<std::string>();
  if (file && column && table->size() == 2)
    found.push_back({key, *file, *column});
  else
    for (const auto& [name, child] : *table)
      find_series(child, key.empty() ? std::string(name.str()) : key + "." + std::string(name.str()), found);
}

} // namespace

std::vector<NamedSeries> time_series(const Scene& scene) {
  std::vector<NamedSeries> found;
  try {
    find_series(toml::parse(schema::write(scene)), "", found);
  } catch (const toml::parse_error&) { // paths need not be UTF-8
  }
  return found;
}

} // namespace signorini::scene
