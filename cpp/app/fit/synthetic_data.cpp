// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/fit/synthetic_data.h"
#include "base/collective.h"
#include "base/error.h"
#include "io/fit_tables.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <map>
#include <random>

namespace signorini {
namespace {

std::vector<double> ends_of_steps(const scene::Time& time) {
  std::vector<double> times;
  for (int k = 1; k <= time.steps; ++k)
    times.push_back(k == time.steps ? time.end : k * time.step);
  return times;
}

/// Writes files, all of them or none but for a failure between two renames. Throws UserError.
void write_files(const std::map<std::filesystem::path, std::string>& files) {
  const auto part = [](const std::filesystem::path& file) {
    return std::filesystem::path(file.string() + ".part");
  };
  std::error_code error;
  for (const auto& [file, text] : files) {
    std::filesystem::create_directories(file.parent_path(), error);
    std::ofstream out(part(file), std::ios::binary);
    out << text << std::flush;
    if (out)
      continue;
    for (const auto& [other, ignored] : files)
      std::filesystem::remove(part(other), error);
    throw UserError(fmt::format(
        "{}: the data cannot be written there, allowed is a folder that can be written", file.string()));
  }
  for (const auto& [file, text] : files)
    std::filesystem::rename(part(file), file);
}

} // namespace

void require_measurable(MPI_Comm comm, const scene::Scene& scene, bool replace) {
  if (std::ranges::none_of(scene.measurements, &scene::Measurement::fitted))
    throw UserError("--measure: found a scene without measurements of values, allowed with [[measurement]]");
  std::map<std::filesystem::path, std::vector<std::string>> columns;
  for (std::size_t i = 0; i < scene.measurements.size(); ++i) {
    const scene::Measurement& one = scene.measurements[i];
    if (!one.fitted())
      continue;
    if (!one.deviation && !one.noise)
      throw UserError(fmt::format("--measure: {} has neither deviation nor noise, allowed with one of them",
                                  scene::measurement_key(i)));
    std::vector<std::string>& names = columns[*one.file];
    if (std::ranges::find(names, one.column) != names.end())
      throw UserError(fmt::format("--measure: {}.column: found \"{}\", which another measurement has in the "
                                  "same file, allowed is another",
                                  scene::measurement_key(i), one.column));
    names.push_back(one.column);
  }
  on_root(comm, [&] {
    for (const auto& [file, names] : columns)
      if (!replace && std::filesystem::exists(file))
        throw UserError(fmt::format("--measure: {} is there already, allowed with --replace", file.string()));
  });
}

SyntheticData::SyntheticData(const forward::Stepper& stepper, const scene::Scene& scene)
    : comm_(stepper.space().comm()), scene_(scene), times_(ends_of_steps(scene.time)),
      measurements_(stepper, scene, std::vector(scene.measurements.size(), times_)) {}

std::vector<std::string> SyntheticData::write(int seed) const {
  struct Table {
    std::vector<std::string> names;
    std::vector<std::vector<double>> columns;
  };
  std::map<std::filesystem::path, Table> tables;
  const std::vector<double> all = measurements_.values();
  std::mt19937_64 source(static_cast<std::uint64_t>(seed));
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < scene_.measurements.size(); ++i) {
    const scene::Measurement& one = scene_.measurements[i];
    if (!one.fitted())
      continue;
    std::vector<double> values(all.begin() + static_cast<std::ptrdiff_t>(measurements_.first()[i]),
                               all.begin() + static_cast<std::ptrdiff_t>(measurements_.first()[i + 1]));
    double deviation = one.deviation.value_or(0);
    for (const double value : values)
      deviation = std::max(deviation, one.noise.value_or(0) * std::abs(value));
    for (double& value : values)
      value += seed > 0 ? deviation * normal(source) : 0;
    Table& table = tables[*one.file];
    table.names.push_back(one.column);
    table.columns.push_back(std::move(values));
  }
  std::map<std::filesystem::path, std::string> texts;
  std::vector<std::string> lines;
  for (const auto& [file, table] : tables) {
    texts[file] = io::data_table(times_, table.names, table.columns);
    lines.push_back(fmt::format("measured: {} ({} values{})", file.string(),
                                times_.size() * table.names.size(),
                                seed > 0 ? fmt::format(", noise by seed {}", seed) : ", without noise"));
  }
  on_root(comm_, [&] { write_files(texts); });
  return lines;
}

} // namespace signorini
