// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/case_table.h"
#include "base/error.h"
#include "scene/csv.h"
#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <optional>
#include <set>

namespace signorini::scene {
namespace {

constexpr const char* name_column = "name";

std::vector<std::string> columns_of(const std::vector<std::string_view>& names, int line) {
  std::vector<std::string> columns;
  for (const std::string_view name : names) {
    if (name.empty())
      throw UserError(fmt::format("line {}: found a column without a name; name it after a key, such as "
                                  "material.young",
                                  line));
    if (std::ranges::find(columns, name) != columns.end())
      throw UserError(fmt::format("line {}: found the column \"{}\" twice; leave out one", line, name));
    columns.emplace_back(name);
  }
  if (std::ranges::all_of(columns, [](const std::string& name) {
        return std::isdigit(static_cast<unsigned char>(name[0])) || name[0] == '-';
      }))
    throw UserError(fmt::format("line {}: found numbers; expected keys as column names", line));
  return columns;
}

} // namespace

std::vector<std::string> CaseTable::overrides(std::size_t i) const {
  std::vector<std::string> all;
  for (std::size_t j = 0; j < keys.size(); ++j)
    if (!rows[i].values[j].empty())
      all.push_back(keys[j] + "=" + rows[i].values[j]);
  return all;
}

CaseTable read_cases(const std::string& text) {
  csv::require_bytes_of_text(text);
  CaseTable table;
  std::vector<std::string> columns;
  std::optional<std::size_t> names;
  std::set<std::string> known;
  char separator = ',';
  csv::for_each_line(text, [&](std::string_view line, int number) {
    if (columns.empty()) {
      separator = csv::separator(line);
      columns = columns_of(csv::cells(line, separator), number);
      const auto found = std::ranges::find(columns, name_column);
      if (found != columns.end())
        names = static_cast<std::size_t>(found - columns.begin());
      for (const std::string& column : columns)
        if (column != name_column)
          table.keys.push_back(column);
      return true;
    }
    const std::vector<std::string_view> cells = csv::cells(line, separator);
    if (cells.size() != columns.size())
      throw UserError(fmt::format("line {}: found {} cells below {} column names; put values that contain "
                                  "the separator in quotes",
                                  number, cells.size(), columns.size()));
    CaseRow row{.name = std::to_string(table.rows.size() + 1), .line = number, .values = {}};
    for (std::size_t j = 0; j < cells.size(); ++j) {
      if (names == j)
        row.name = csv::unescaped(cells[j]);
      else
        row.values.push_back(csv::unescaped(cells[j]));
    }
    if (row.name.empty())
      throw UserError(
          fmt::format("line {}: found a case without a name; name it or remove the column", number));
    if (!known.insert(row.name).second)
      throw UserError(
          fmt::format("line {}: found a second case \"{}\"; names must differ", number, row.name));
    table.rows.push_back(std::move(row));
    return true;
  });
  if (table.rows.empty())
    throw UserError("found no cases; expected a line of keys, and a line of values for each case");
  return table;
}

} // namespace signorini::scene
