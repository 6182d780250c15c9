// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace signorini::scene {

/// Function that reads a file; throws UserError if it cannot be read.
using ReadFile = std::function<std::string(const std::filesystem::path&)>;

/// Returns the text of a regular file. Throws UserError naming the file if it cannot be read or is empty.
std::string read_file(const std::filesystem::path& file);

/// A quantity over time, given by a table; linear between the table's times, constant before and after them.
class TimeSeries {
public:
  /// Reads a column of the text of a CSV file as read_column() does. Throws UserError naming line or column.
  TimeSeries(const std::string& text, const std::string& column);

  [[nodiscard]] double operator()(double t) const;
  /// Rate of change at time t (s), per second. At a time of the table: the rate just before t or, if `after`,
  /// just after t.
  [[nodiscard]] double slope(double t, bool after) const;
  /// Times of the table, s, ascending.
  [[nodiscard]] const std::vector<double>& times() const { return times_; }
  /// Values at times().
  [[nodiscard]] const std::vector<double>& values() const { return values_; }
  /// First time of the table, s.
  [[nodiscard]] double begin() const { return times_.front(); }
  /// Last time of the table, s.
  [[nodiscard]] double end() const { return times_.back(); }

private:
  std::vector<double> times_, values_; ///< ascending times, at least two, and a value for each
};

} // namespace signorini::scene
