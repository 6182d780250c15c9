// SPDX-License-Identifier: GPL-3.0-or-later
#include "drivers/synthetic_data.h"
#include "base/collective.h"
#include "base/digest.h"
#include "base/error.h"
#include "io/fit_tables.h"
#include "io/output_folder.h"
#include "scene/table.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <map>
#include <random>
#include <unistd.h>
#include <utility>

namespace signorini::drivers {
namespace fs = std::filesystem;

namespace {

std::vector<double> ends_of_steps(const scene::Time& time) {
  std::vector<double> times;
  for (int k = 1; k <= time.steps; ++k)
    times.push_back(k == time.steps ? time.end : k * time.step);
  return times;
}

constexpr const char* author = "signorini simulate --measure";

fs::path note_of(const fs::path& file) { return file.string() + ".measured"; }

/// Reads the digests in a note: that of the file as written, and that of the file which it replaced. Empty if
/// there is no valid note. If a process is killed between writing note and file, the second digest still
/// identifies the old file.
std::vector<std::string> digests_in(const fs::path& note) {
  std::vector<std::string> digests;
  std::ifstream in(note, std::ios::binary);
  std::string line;
  if (!std::getline(in, line) || line.find(author) == std::string::npos)
    return {};
  while (std::getline(in, line))
    if (!line.starts_with('#'))
      digests.push_back(line);
  return digests;
}

std::string digest_of(const fs::path& file) { return Digest().add(scene::read_file(file)).text(); }

/// Writes a temporary file beside `file`, under a name that no other process uses; returns its path. Throws
/// UserError.
fs::path staged(const fs::path& file, const std::string& text) {
  const fs::path part = file.parent_path() / fmt::format(".{}.{}", file.filename().string(), getpid());
  std::ofstream out(part, std::ios::binary);
  out << text << std::flush;
  if (out)
    return part;
  std::error_code ignored;
  fs::remove(part, ignored);
  throw UserError(
      fmt::format("{}: the data cannot be written to this path; choose another folder", file.string()));
}

/// Writes files and their notes. Throws UserError if that fails; then no file has changed, unless the failure
/// is in renaming.
void write_files(const std::map<fs::path, std::string>& files) {
  std::vector<std::pair<fs::path, fs::path>> moves; // in this order: the note precedes its file
  try {
    for (const auto& [file, text] : files) {
      std::error_code error;
      fs::create_directories(file.parent_path(), error);
      std::string note =
          fmt::format("# Digests of {}: as written by {}, and of the file that it replaced.\n# --replace "
                      "overwrites the file while its digest is one of these.\n{}\n",
                      file.filename().string(), author, Digest().add(text).text());
      if (fs::exists(file))
        note += digest_of(file) + '\n';
      moves.emplace_back(staged(note_of(file), note), note_of(file));
      moves.emplace_back(staged(file, text), file);
    }
  } catch (const UserError&) {
    std::error_code ignored;
    for (const auto& [part, place] : moves)
      fs::remove(part, ignored);
    throw;
  }
  for (const auto& [part, place] : moves) {
    std::error_code error;
    fs::rename(part, place, error);
    if (error)
      throw UserError(fmt::format("{}: the data cannot be written to this path ({}); choose another folder",
                                  place.string(), error.message()));
  }
}

/// Throws UserError unless the file of a measurement may be written (require_measurable()).
void require_ours(const fs::path& file, const scene::Scene& scene, const fs::path& out, bool replace) {
  std::error_code none;
  if (fs::weakly_canonical(file.parent_path(), none) == fs::weakly_canonical(fs::absolute(out), none) &&
      io::OutputFolder::writes(file.filename().string()))
    throw UserError(fmt::format("--measure: {} is a file of the run itself; choose another measurement.file",
                                file.string()));
  const fs::path note = note_of(file);
  const std::vector<std::string> known = digests_in(note);
  if (known.empty() && fs::exists(fs::symlink_status(note, none)))
    throw UserError(fmt::format(
        "--measure: {} has the name of the note that is written beside the data; move it", note.string()));
  if (!fs::exists(fs::symlink_status(file, none)))
    return;
  if (!replace)
    throw UserError(fmt::format(
        "--measure: {} exists and is not overwritten, since a fit may use it; to overwrite it, add --replace",
        file.string()));
  for (const scene::NamedSeries& series : scene::time_series(scene))
    if (fs::equivalent(series.file, file, none))
      throw UserError(fmt::format(
          "--measure: {} is a table that the scene reads; choose another measurement.file", file.string()));
  if (known.empty() || !fs::is_regular_file(file, none))
    throw UserError(fmt::format("--measure: {} was not written by simulate --measure (there is no {}), and "
                                "is not overwritten; choose another measurement.file, or move the file",
                                file.string(), note.filename().string()));
  if (std::ranges::find(known, digest_of(file)) == known.end())
    throw UserError(fmt::format("--measure: {} has changed since simulate --measure wrote it, and is not "
                                "overwritten; choose another measurement.file, or move the file",
                                file.string()));
}

} // namespace

void require_measurable(MPI_Comm comm, const scene::Scene& scene, const std::filesystem::path& out,
                        bool replace) {
  if (std::ranges::none_of(scene.measurements, &scene::Measurement::fitted))
    throw UserError("--measure: the scene measures no values; add a table [[measurement]]");
  std::map<std::filesystem::path, std::vector<std::string>> columns;
  for (std::size_t i = 0; i < scene.measurements.size(); ++i) {
    const scene::Measurement& one = scene.measurements[i];
    if (!one.fitted())
      continue;
    if (!one.deviation && !one.noise)
      throw UserError(fmt::format("--measure: {} has neither deviation nor noise; give one of them",
                                  scene::measurement_key(i)));
    std::vector<std::string>& names = columns[*one.file];
    if (one.column == "time")
      throw UserError(
          fmt::format("--measure: {}.column: found \"time\", which is the column of times; choose another",
                      scene::measurement_key(i)));
    if (std::ranges::find(names, one.column) != names.end())
      throw UserError(fmt::format("--measure: {}.column: found \"{}\", which another measurement uses in the "
                                  "same file; choose another",
                                  scene::measurement_key(i), one.column));
    names.push_back(one.column);
  }
  on_root(comm, [&] {
    for (const auto& [file, names] : columns)
      require_ours(file, scene, out, replace);
  });
}

SyntheticData::SyntheticData(const step::Stepper& stepper, const step::TimeGrid& grid,
                             const scene::Scene& scene)
    : comm_(stepper.space().comm()), scene_(scene), times_(ends_of_steps(scene.time)),
      measurements_(stepper, grid, scene, std::vector(scene.measurements.size(), times_)) {}

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

} // namespace signorini::drivers
