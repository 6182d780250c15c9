// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include <string>
#include <vector>

namespace signorini::scene {

/// A quantity of a CSV table.
struct TableColumn {
  std::vector<double> times, values; ///< SI, as many; times ascending, at least two
  std::string time_name;             ///< of the column of times, if it states no unit
  std::string name;                  ///< of the quantity's column, with its unit
  double factor = 1;                 ///< SI units in one of it, by which values were converted
  std::string unconverted;           ///< the quantity's name, if it ends with a unit that is not applied
};

/// Reads a column of a CSV text: numbers below one line of names, separated by commas, semicolons or tabs;
/// quoted cells may contain these; lines that begin with # are skipped. Times are in the column "time" or
/// "t", else in the first. A name may end with a unit in brackets, as "time [ms]" or "x [mm]", by which its
/// values are converted to SI (unit()); a name that equals `column` as a whole has none. `units`: those that
/// the quantity may have, unchecked if empty. Throws UserError naming line or column.
TableColumn read_column(const std::string& text, const std::string& column,
                        const std::vector<std::string>& units = {});

/// Whether a text's line of names has a column, with or without a unit.
bool has_column(const std::string& text, const std::string& column);

/// How to state the unit of a table's times, for messages; empty if the table does.
std::string unit_hint(const TableColumn& column);

/// A reason to doubt that a table is read as it was meant; `value` exceeds `limit`.
struct TableWarning {
  std::string message;
  double value, limit;
};

/// Doubts about a load or a motion over a run from 0 to `end` (s), which the table covers: that the run uses
/// one interval of several, or a thousandth or less of times without a unit, or that a unit is not applied.
std::vector<TableWarning> input_warnings(const TableColumn& column, double end);
/// Doubts about data of a run from 0 to `end` (s): that times without a unit span a thousandth or less of
/// it, that they end before it, or that a unit is not applied.
std::vector<TableWarning> doubts_as_data(const TableColumn& column, double end);

/// A time series by the key that it is the value of.
struct NamedSeries {
  std::string key;
  std::filesystem::path file; ///< absolute
  std::string column;
};
/// The time series of a scene.
std::vector<NamedSeries> time_series(const Scene& scene);

} // namespace signorini::scene
