// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/fit_tables.h"
#include "base/collective.h"
#include "base/error.h"
#include "scene/table.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

namespace signorini::io {
namespace {

/// Throws UserError unless all times of the data are from 0 to `end` (s), up to rounding. `hint`: end of the
/// message.
void require_within(const control::Data& data, double end, const std::string& hint) {
  const double hair = 1e-9 * end;
  for (const double t : {data.times.front(), data.times.back()})
    if (t < -hair || t > end + hair)
      throw UserError(fmt::format("found the time {:.10g} s; expected times of the motion, 0 to {:.10g} s{}",
                                  t, end, hint));
}

/// Unit that a measured quantity may have. `depth`: scene::per_depth(); forces per metre may be given as
/// forces of a slice 1 m deep.
std::vector<std::string> units(scene::Quantity of, const std::string& depth) {
  const auto per_depth = [&](const std::string& unit) {
    return depth.empty() ? std::vector{unit} : std::vector{unit, unit + depth};
  };
  switch (of) {
  case scene::Quantity::displacement:
    return {"m"};
  case scene::Quantity::velocity:
    return {"m/s"};
  case scene::Quantity::force:
    return per_depth("N");
  case scene::Quantity::impulse:
    return per_depth("N s");
  default: // of the whole contact, in no table
    return {};
  }
}

control::Data data_of(const scene::Measurement& measurement, const std::string& text, double end,
                      const std::string& depth) {
  const std::vector<std::string> allowed = units(measurement.of, depth);
  const scene::TableColumn given = scene::read_column(text, measurement.column, allowed);
  control::Data data{.times = given.times,
                     .values = given.values,
                     .deviations = {},
                     .warnings = scene::data_warnings(given, end)};
  require_within(data, end, scene::unit_hint(given));
  double deviation = measurement.deviation.value_or(0);
  if (measurement.noise) {
    for (const double value : data.values)
      deviation = std::max(deviation, *measurement.noise * std::abs(value));
    if (deviation == 0)
      throw UserError("all values are 0, so noise relative to them is undefined; give a deviation");
  }
  constexpr const char* column = "deviation";
  if (deviation > 0) {
    data.deviations.assign(data.values.size(), deviation);
  } else {
    if (!scene::has_column(text, column))
      throw UserError("found no column \"deviation\"; add one, or the key deviation or noise");
    const scene::TableColumn deviations = scene::read_column(text, column, allowed);
    if (deviations.name == column && given.factor != 1)
      throw UserError(fmt::format(
          "found \"{0}\" without a unit, but \"{1}\" with one; name the former \"{0}{2}\", or add its actual "
          "unit",
          column, given.name, given.name.substr(measurement.column.size())));
    data.deviations = deviations.values;
    if (std::ranges::any_of(data.deviations, [](double x) { return !(x > 0); }))
      throw UserError("found a deviation of 0 or less; expected numbers above 0");
  }
  return data;
}

} // namespace

std::vector<control::Data> read_data(MPI_Comm comm, const scene::Scene& scene) {
  // A scene does not state its dimension; in space "N/m" is accepted, too.
  const std::string depth = scene.mesh.per_depth(2);
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
        throw UserError(
            fmt::format("{}: {}; signorini simulate --measure writes such a file", key, error.what()));
      }
    });
    text = broadcast(comm, text);
    try {
      all.back() = data_of(measurement, text, scene.time.end, depth);
      for (scene::TableWarning& warning : all.back().warnings)
        warning.message = fmt::format("{}: {}: {}", key, measurement.file->string(), warning.message);
    } catch (const UserError& error) {
      throw UserError(fmt::format("{}: {}: {}", key, measurement.file->string(), error.what()));
    }
  }
  return all;
}

std::string data_table(const std::vector<double>& times, const std::vector<std::string>& names,
                       const std::vector<std::vector<double>>& columns) {
  std::string text = "time";
  for (const std::string& name : names)
    text += name.find_first_of(",;\t") == std::string::npos ? "," + name : ",\"" + name + '"';
  text += '\n';
  for (std::size_t k = 0; k < times.size(); ++k) {
    fmt::format_to(std::back_inserter(text), "{}", times[k]);
    for (const std::vector<double>& column : columns)
      fmt::format_to(std::back_inserter(text), ",{}", column[k]);
    text += '\n';
  }
  return text;
}

std::string parameters_table(const Fit& fit) {
  std::string text = "name,of,unit,value,standard_deviation,start,lower,upper,scale,at_bound,gradient\n";
  for (const FittedUnknown& one : fit.unknowns)
    fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{},{},{},{},{}\n", one.name, one.quantity,
                   one.unit, one.value, one.deviation, one.start, one.lower, one.upper, one.scale,
                   one.at_bound ? 1 : 0, one.gradient);
  return text;
}

std::string measurements_table(const Fit& fit) {
  std::string text = "measurement,time,value,deviation,simulated,residual\n";
  for (const Comparison& one : fit.measurements)
    for (std::size_t k = 0; k < one.times.size(); ++k)
      fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{}\n", one.name, one.times[k], one.data[k],
                     one.deviations[k], one.simulated[k],
                     (one.simulated[k] - one.data[k]) / one.deviations[k]);
  return text;
}

} // namespace signorini::io
