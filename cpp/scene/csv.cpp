// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/csv.h"
#include "base/error.h"

namespace signorini::scene {
namespace {

constexpr std::string_view blanks = " \t";

/// Calls visit(c, i) for each character c of a line, at index i, that is not in a quoted cell.
template <class Visit>
void outside_quotes(std::string_view line, Visit&& visit) {
  bool quoted = false, start = true; // of a cell: a quote within one is part of its text
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && (quoted || start)) {
      quoted = !quoted;
    } else if (!quoted) {
      visit(c, i);
      start = c == ',' || c == ';' || c == '\t' || (start && c == ' ');
    }
  }
}

} // namespace

std::string_view csv::trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(blanks);
  return first == std::string_view::npos ? std::string_view()
                                         : text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::vector<std::string_view> csv::cells(std::string_view line, char separator) {
  std::vector<std::string_view> found;
  std::size_t start = 0;
  const auto add = [&](std::size_t end) {
    std::string_view cell = trimmed(line.substr(start, end - start));
    if (cell.size() > 1 && cell.starts_with('"') && cell.ends_with('"'))
      cell = trimmed(cell.substr(1, cell.size() - 2));
    found.push_back(cell);
    start = end + 1;
  };
  outside_quotes(line, [&](char c, std::size_t i) {
    if (c == separator)
      add(i);
  });
  add(line.size());
  return found;
}

std::string csv::unescaped(std::string_view cell) {
  std::string text;
  for (std::size_t i = 0; i < cell.size(); ++i) {
    text += cell[i];
    if (cell[i] == '"' && i + 1 < cell.size() && cell[i + 1] == '"')
      ++i;
  }
  return text;
}

std::string csv::cell(const std::string& text) {
  if (text.find_first_of(",;\t\"\r\n") == std::string::npos)
    return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"')
      quoted += '"';
    quoted += c == '\n' || c == '\r' ? ' ' : c; // a row is a line
  }
  return quoted + '"';
}

char csv::separator(std::string_view names) {
  char found = ',';
  outside_quotes(names, [&](char c, std::size_t) {
    if (c == '\t' || (c == ';' && found == ','))
      found = c;
  });
  return found;
}

std::string_view csv::take_line(std::string_view& text) {
  const std::string_view line = text.substr(0, text.find_first_of("\r\n"));
  text.remove_prefix(line.size());
  if (!text.empty())
    text.remove_prefix(text.starts_with("\r\n") ? 2 : 1);
  return line;
}

void csv::require_bytes_of_text(std::string_view text) {
  if (text.find('\0') != std::string_view::npos)
    throw UserError("found a zero byte, as in UTF-16 and in binary files; save the table as UTF-8");
}

} // namespace signorini::scene
