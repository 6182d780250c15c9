// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/fit_tables.h"
#include "base/collective.h"
#include "base/error.h"
#include "scene/time_series.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iterator>

namespace signorini::io {
namespace {

/// Throws UserError unless all times are within the motion, up to rounding.
void require_within(const control::Data& data, double end) {
  const double hair = 1e-9 * end;
  for (const double t : {data.times.front(), data.times.back()})
    if (t < -hair || t > end + hair)
      throw UserError(
          fmt::format("found the time {:.10g} s, allowed are times of the motion, 0 to {:.10g} s", t, end));
}

control::Data data_of(const scene::Measurement& measurement, const std::string& text, double end) {
  const scene::TimeSeries series(text, measurement.column);
  control::Data data{.times = series.times(), .values = series.values(), .deviations = {}};
  require_within(data, end);
  double deviation = measurement.deviation.value_or(0);
  if (measurement.noise) {
    for (const double value : data.values)
      deviation = std::max(deviation, *measurement.noise * std::abs(value));
    if (deviation == 0)
      throw UserError("found zeros alone, to which no noise can be relative; allowed is deviation");
  }
  constexpr const char* column = "deviation";
  if (deviation > 0) {
    data.deviations.assign(data.values.size(), deviation);
  } else {
    if (!scene::TimeSeries::has_column(text, column))
      throw UserError("found no column \"deviation\", allowed is one, or the key deviation or noise");
    data.deviations = scene::TimeSeries(text, column).values();
    if (std::ranges::any_of(data.deviations, [](double x) { return !(x > 0); }))
      throw UserError("found a deviation of 0 or less, allowed are numbers greater than 0");
  }
  return data;
}

} // namespace

std::vector<control::Data> read_data(MPI_Comm comm, const scene::Scene& scene) {
  std::vector<control::Data> all;
  for (std::size_t i = 0; i < scene.measurements.size(); ++i) {
    const scene::Measurement& measurement = scene.measurements[i];
    all.emplace_back();
    if (!measurement.fitted())
      continue;
    const std::string key = scene::measurement_key(i) + ".file";
    std::string text;
    on_root(comm, [&] {
      try {
        text = scene::read_file(*measurement.file);
      } catch (const UserError& error) {
        throw UserError(fmt::format("{}: {}; signorini simulate --measure writes one", key, error.what()));
      }
    });
    text = broadcast(comm, text);
    try {
      all.back() = data_of(measurement, text, scene.time.end);
    } catch (const UserError& error) {
      throw UserError(fmt::format("{}: {}: {}", key, measurement.file->string(), error.what()));
    }
  }
  return all;
}

std::string data_table(const std::vector<double>& times, const std::vector<std::string>& names,
                       const std::vector<std::vector<double>>& columns) {
  std::string text = fmt::format("time,{}\n", fmt::join(names, ","));
  for (std::size_t k = 0; k < times.size(); ++k) {
    fmt::format_to(std::back_inserter(text), "{:.17g}", times[k]);
    for (const std::vector<double>& column : columns)
      fmt::format_to(std::back_inserter(text), ",{:.17g}", column[k]);
    text += '\n';
  }
  return text;
}

std::string parameters_table(const Fit& fit) {
  std::string text = "name,of,unit,value,standard_deviation,start,lower,upper,scale,at_bound,gradient\n";
  for (const FittedUnknown& one : fit.unknowns)
    fmt::format_to(std::back_inserter(text),
                   "{},{},{},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{},{},{:.17g}\n", one.name, one.of,
                   one.unit, one.value, one.deviation, one.start, one.lower, one.upper, one.scale,
                   one.at_bound ? 1 : 0, one.gradient);
  return text;
}

std::string measurements_table(const Fit& fit) {
  std::string text = "measurement,time,value,deviation,simulated,residual\n";
  for (const Comparison& one : fit.measurements)
    for (std::size_t k = 0; k < one.times.size(); ++k)
      fmt::format_to(std::back_inserter(text), "{},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g}\n", one.name,
                     one.times[k], one.data[k], one.deviations[k], one.simulated[k],
                     (one.simulated[k] - one.data[k]) / one.deviations[k]);
  return text;
}

} // namespace signorini::io
