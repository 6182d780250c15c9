// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include <string>
#include <vector>

namespace signorini::scene {

/// Times and values of one column of a CSV table.
struct TableColumn {
  std::vector<double> times, values; ///< at least two ascending times (s), and a value (SI) for each
  std::string time_name;             ///< name of the time column if that name states no unit, else empty
  std::string name;                  ///< name of the column of values, with its unit
  double factor = 1;                 ///< factor from the column's unit to SI, already applied to the values
  std::string unconverted;           ///< name of the column if its unit was not converted to SI, else empty
};

/// Reads a column of a CSV text with one line of column names above lines of numbers. Cells are separated by
/// commas, semicolons or tabs, which quoted cells may contain; lines that begin with # are skipped. The times
/// are in the column "time" or "t", else in the first column. A column name may end with a unit in brackets,
/// as "time [ms]" or "x [mm]"; the column is then converted to SI (unit()). If `column` includes the
/// brackets, the values are not converted. The column's unit must have the dimension of one of `units`; if
/// `units` is empty, any unit is accepted. Throws UserError naming line or column.
TableColumn read_column(const std::string& text, const std::string& column,
                        const std::vector<std::string>& units = {});

/// Whether the line of column names in a CSV text has `column`, with or without a unit.
bool has_column(const std::string& text, const std::string& column);

/// Hint, for messages, on how to state the unit of a table's times; empty if the table states the unit.
std::string unit_hint(const TableColumn& column);

/// A warning that a table may not be read as intended.
struct TableWarning {
  std::string message;
  double value, limit; ///< value that caused the warning, and the limit that it exceeds
};

/// Warnings about a table that prescribes a load or motion of a run from 0 to `end` (s). The table must cover
/// the run. Reasons for a warning: the run uses only one of several intervals of the table; the times state
/// no unit and span about 1000 times the run or more; or the values are read as SI although the column's name
/// states another unit.
std::vector<TableWarning> input_warnings(const TableColumn& column, double end);
/// Warnings about a table of measured data for a run from 0 to `end` (s). Reasons for a warning: the times
/// state no unit and span about a thousandth of the run or less; the data end before the run, by more than
/// their longest interval; or the values are read as SI although the column's name states another unit.
std::vector<TableWarning> data_warnings(const TableColumn& column, double end);

/// A time series that a scene names as the value of a key.
struct NamedSeries {
  std::string key;
  std::filesystem::path file; ///< path of the CSV file, absolute
  std::string column;         ///< column of the values
};
/// All time series that a scene names.
std::vector<NamedSeries> time_series(const Scene& scene);

} // namespace signorini::scene
