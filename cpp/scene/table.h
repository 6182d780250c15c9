// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include <string>
#include <vector>

namespace signorini::scene {

/// A quantity of a CSV table.
struct TableColumn {
  std::vector<double> times, values; ///< SI, as many; times ascending, at least two
  std::string time_name;             ///< name of the column of times, if it states no unit
  std::string name;                  ///< name of the quantity's column, with its unit
  double factor = 1;                 ///< SI units per unit of the column, already applied
  std::string unconverted;           ///< the quantity's name, if it ends with a unit that is not applied
};

/// Reads a column of a CSV text: numbers below one line of names, separated by commas, semicolons or tabs.
/// Quoted cells may contain these; lines that begin with # are skipped. Times are in the column "time" or
/// "t", else in the first. A name may end with a unit in brackets, as "time [ms]" or "x [mm]", by which its
/// values are converted to SI (unit()). A name that equals `column` as a whole has no unit. `units`: those
/// that the quantity may have, unchecked if empty. Throws UserError naming line or column.
TableColumn read_column(const std::string& text, const std::string& column,
                        const std::vector<std::string>& units = {});

/// Whether a text's line of names has a column, with or without a unit.
bool has_column(const std::string& text, const std::string& column);

/// Hint, for messages, on how to state the unit of a table's times; empty if the table states it.
std::string unit_hint(const TableColumn& column);

/// A warning that a table may not be read as intended; `value` exceeds `limit`.
struct TableWarning {
  std::string message;
  double value, limit;
};

/// Warnings about a load or a motion over a run from 0 to `end` (s), which the table covers. Reasons: the run
/// uses one interval of several, or a thousandth or less of times without a unit, or a unit is not applied.
std::vector<TableWarning> input_warnings(const TableColumn& column, double end);
/// Warnings about data of a run from 0 to `end` (s). Reasons: times without a unit span a thousandth or less
/// of it, the data end before it, or a unit is not applied.
std::vector<TableWarning> doubts_as_data(const TableColumn& column, double end);

/// Time series that is the value of a key.
struct NamedSeries {
  std::string key;
  std::filesystem::path file; ///< absolute
  std::string column;
};
/// Time series of a scene.
std::vector<NamedSeries> time_series(const Scene& scene);

} // namespace signorini::scene
