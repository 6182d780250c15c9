// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <string>
#include <string_view>
#include <vector>

/// Lines and cells of tables in CSV, as spreadsheets and data loggers write them.
namespace signorini::scene::csv {

/// Removes blanks and tabs around a text.
std::string_view trimmed(std::string_view text);

/// Splits a line into cells, and strips blanks and quotes around each cell.
std::vector<std::string_view> cells(std::string_view line, char separator);

/// Returns one of cells() without the doubling of quotes within quoted cells.
std::string unescaped(std::string_view cell);
/// Returns a text as a cell of a table, on one line and in quotes if necessary.
std::string cell(const std::string& text);

/// Separator of cells, from the line of column names: a tab if there is one, else a semicolon, else a comma.
/// Tabs and semicolons take precedence, since names may contain commas.
char separator(std::string_view names);

/// Removes the first line from a text and returns it. Lines end with LF, CR LF or, in old files, CR.
std::string_view take_line(std::string_view& text);

/// Calls visit(line, number of the line) for the lines of a table until `visit` returns false. Skips empty
/// lines, comments, and Excel's first line `sep=;`.
template <class Visit>
void for_each_line(std::string_view text, Visit&& visit) {
  if (text.starts_with("\xef\xbb\xbf")) // the mark by which some programs begin UTF-8
    text.remove_prefix(3);
  for (int number = 1; !text.empty(); ++number) {
    const std::string_view line = take_line(text);
    const bool skipped =
        trimmed(line).empty() || line.starts_with('#') || (number == 1 && line.starts_with("sep="));
    if (!skipped && !visit(line, number))
      return;
  }
}

/// Throws UserError if a text has a zero byte, as binary files and the UTF-16 of spreadsheets have.
void require_bytes_of_text(std::string_view text);

} // namespace signorini::scene::csv
