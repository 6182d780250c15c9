// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/time_series.h"
#include "base/error.h"
#include "scene/table.h"
#include <algorithm>
#include <fmt/format.h>
#include <fstream>
#include <sstream>
#include <utility>

namespace signorini::scene {

std::string read_file(const std::filesystem::path& file) {
  std::error_code none;
  std::ifstream in;
  if (std::filesystem::is_regular_file(file, none)) // reading others may never end
    in.open(file, std::ios::binary);
  std::ostringstream text;
  if (!in.is_open() || !(text << in.rdbuf()))
    throw UserError(fmt::format("{}: cannot be read; give a file that is not empty", file.string()));
  return text.str();
}

TimeSeries::TimeSeries(const std::string& text, const std::string& column) {
  TableColumn found = read_column(text, column);
  times_ = std::move(found.times);
  values_ = std::move(found.values);
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
  // Times of steps are sums, which differ from the table's by rounding.
  const double hair = 1e-9 * (end() - begin()) / static_cast<double>(times_.size() - 1);
  const auto above = std::ranges::upper_bound(times_, after ? t + hair : t - hair);
  if (above == times_.begin() || above == times_.end())
    return 0;
  const auto i = static_cast<std::size_t>(above - times_.begin());
  return (values_[i] - values_[i - 1]) / (times_[i] - times_[i - 1]);
}

} // namespace signorini::scene
