// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace signorini::scene {

/// Function that reads a file; throws UserError if it cannot be read.
using ReadFile = std::function<std::string(const std::filesystem::path&)>;

/// Returns the text of a regular file. Throws UserError naming it if it cannot be read.
std::string read_file(const std::filesystem::path& file);

/// Quantity that a table gives at times, linear between them and constant beyond.
class TimeSeries {
public:
  /// Reads a column of the text of a CSV file as read_column() does. Throws UserError naming line or column.
  TimeSeries(const std::string& text, const std::string& column);

  [[nodiscard]] double operator()(double t) const;
  /// Slope at t, per second; where two lines meet, that before t or, with `after`, that after it.
  [[nodiscard]] double slope(double t, bool after) const;
  /// Times of the table, s, and the values there.
  [[nodiscard]] const std::vector<double>& times() const { return times_; }
  [[nodiscard]] const std::vector<double>& values() const { return values_; }
  /// First and last time of the table, s.
  [[nodiscard]] double begin() const { return times_.front(); }
  [[nodiscard]] double end() const { return times_.back(); }

private:
  std::vector<double> times_, values_; ///< times ascending, at least two
};

} // namespace signorini::scene
