// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/results.h"
#include "base/error.h"
#include "io/manifest.h"
#include "io/output_folder.h"
#include "scene/csv.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <ranges>
#include <sstream>

namespace signorini::batch {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char *table_file = "cases.csv", *manifest_file = "batch.json", *scene_file = "scene.toml";
const io::FolderLock::Names file_names{table_file, manifest_file, scene_file};
constexpr std::size_t own_columns = 4; ///< outcome, reason, warnings, steps
constexpr const char *done = "done", *failed_word = "failed";

std::string content(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Names of the numbers of all outcomes, in the order in which they first occur.
std::vector<std::string> columns(const std::vector<std::optional<Outcome>>& outcomes) {
  std::vector<std::string> names;
  for (const std::optional<Outcome>& outcome : outcomes)
    if (outcome)
      for (const auto& [name, value] : outcome->numbers)
        if (std::ranges::find(names, name) == names.end())
          names.push_back(name);
  return names;
}

constexpr const char* separator = "; "; ///< between the warnings of a case

/// Splits a cell of warnings.
std::vector<std::string> words(const std::string& cell) {
  std::vector<std::string> found;
  for (std::size_t begin = 0; begin < cell.size();) {
    const std::size_t end = std::min(cell.find(separator, begin), cell.size());
    found.push_back(cell.substr(begin, end - begin));
    begin = end + std::char_traits<char>::length(separator);
  }
  return found;
}

/// Message of a kind of warning in batch.json; the kind itself if there is none.
std::string message_of(const Json& manifest, const std::string& kind) {
  for (const Json& one : manifest.value("warnings", Json::array()))
    if (one.is_object() && one.value("name", "") == kind)
      return one.value("message", kind);
  return kind;
}

} // namespace

Results::Results(const std::filesystem::path& folder, const scene::Scene& scene,
                 const scene::CaseTable& table, std::string origin, std::optional<Shard> shard)
    : folder_(folder), lock_(folder), scene_(scene), table_(table), origin_(std::move(origin)), shard_(shard),
      outcomes_(table.rows.size()) {
  lock_.claim(manifest_file, file_names, file_names);
}

void Results::set(const std::vector<accuracy::Quantity>& quantities) {
  for (const accuracy::Quantity& one : quantities)
    quantities_.emplace(one.name, one);
}

std::size_t Results::ended() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(outcomes_, [](const auto& outcome) { return outcome.has_value(); }));
}

std::size_t Results::failed() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      outcomes_, [](const auto& outcome) { return outcome && !outcome->reason.empty(); }));
}

std::vector<Results::Trouble> Results::troubles(bool warnings) const {
  std::vector<Trouble> found;
  const auto add = [&](std::size_t i, const std::string& kind, const std::string& message) {
    const auto known = std::ranges::find(found, kind, &Trouble::kind);
    if (known == found.end())
      found.push_back({kind, message, i, 1});
    else
      ++known->cases;
  };
  for (std::size_t i = 0; i < outcomes_.size(); ++i) {
    if (!outcomes_[i])
      continue;
    if (warnings)
      for (const auto& [kind, message] : outcomes_[i]->warnings)
        add(i, kind, message);
    else if (const std::string& reason = outcomes_[i]->reason; !reason.empty())
      add(i, reason, reason);
  }
  std::ranges::stable_sort(found, std::greater(), &Trouble::cases);
  return found;
}

std::vector<std::string> Results::trouble_lines(std::size_t most) const {
  std::vector<std::string> lines;
  const auto add = [&](bool warnings, const char* what) {
    const std::vector<Trouble> all = troubles(warnings);
    for (const Trouble& one : all | std::views::take(most))
      lines.push_back(fmt::format("{}, {} of {} cases, first case {}: {}", what, one.cases, ended(),
                                  table_.rows[one.first].name, one.message));
    if (all.size() > most)
      lines.push_back(fmt::format("and {} more kinds: see {}", all.size() - most, table_file));
  };
  add(false, "failed");
  add(true, "warning");
  return lines;
}

std::size_t Results::resume() {
  std::size_t found = take(folder_);
  std::error_code none;
  if (!shard_)
    for (const auto& entry : std::filesystem::directory_iterator(folder_, none))
      if (entry.is_directory(none) && entry.path().filename().string().starts_with("shard-"))
        found += take(entry.path());
  return found;
}

std::size_t Results::take(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / table_file;
  std::error_code none;
  if (!std::filesystem::exists(file, none))
    return 0;
  const Json manifest = Json::parse(content(folder / manifest_file), nullptr, false);
  if (!manifest.is_object() || manifest.value("origin", "") != origin_)
    throw UserError(fmt::format("--resume: {} has outcomes of another scene, version or choice of "
                                "quantities; choose another folder or leave out --resume",
                                folder.string()));
  std::map<std::string, std::size_t> number_of;
  for (std::size_t i = 0; i < table_.rows.size(); ++i)
    number_of[table_.rows[i].name] = i;
  std::vector<std::string> header;
  std::size_t found = 0;
  const std::size_t first = 1 + table_.keys.size(); // column of the outcome
  const std::string text = content(file);
  scene::csv::for_each_line(text, [&](std::string_view line, int) {
    std::vector<std::string> cells;
    for (const std::string_view cell : scene::csv::cells(line, ','))
      cells.push_back(scene::csv::unescaped(cell));
    if (header.empty()) {
      header = cells;
      return true;
    }
    const auto known = number_of.find(cells.front());
    if (cells.size() != header.size() || header.size() < first + own_columns ||
        header[first + 2] != "warnings" || known == number_of.end() || outcomes_[known->second] ||
        !std::equal(table_.rows[known->second].values.begin(), table_.rows[known->second].values.end(),
                    cells.begin() + 1))
      return true; // of another case
    Outcome outcome{.steps = std::atoi(cells[first + 3].c_str()), .reason = cells[first + 1]};
    for (const std::string& kind : words(cells[first + 2]))
      outcome.warnings[kind] = message_of(manifest, kind);
    for (std::size_t j = first + own_columns; j < cells.size(); ++j)
      if (!cells[j].empty())
        outcome.numbers.emplace_back(header[j], std::strtod(cells[j].c_str(), nullptr));
    outcomes_[known->second] = std::move(outcome);
    ++found;
    return true;
  });
  return found;
}

std::string Results::table_text() const {
  const std::vector<std::string> names = columns(outcomes_);
  std::string text = "case";
  for (const std::string& key : table_.keys)
    text += "," + scene::csv::cell(key);
  text += ",outcome,reason,warnings,steps";
  for (const std::string& name : names)
    text += "," + scene::csv::cell(name);
  text += '\n';
  for (std::size_t i = 0; i < outcomes_.size(); ++i) {
    if (!outcomes_[i])
      continue;
    const Outcome& outcome = *outcomes_[i];
    text += scene::csv::cell(table_.rows[i].name);
    for (const std::string& value : table_.rows[i].values)
      text += "," + scene::csv::cell(value);
    text += fmt::format(
        ",{},{},{},{}", outcome.reason.empty() ? done : failed_word, scene::csv::cell(outcome.reason),
        scene::csv::cell(fmt::format("{}", fmt::join(outcome.warnings | std::views::keys, separator))),
        outcome.steps);
    for (const std::string& name : names) {
      const auto found = std::ranges::find(outcome.numbers, name, &Numbers::value_type::first);
      text += ',';
      if (found != outcome.numbers.end() && std::isfinite(found->second))
        text += fmt::format("{:.17g}", found->second);
    }
    text += '\n';
  }
  return text;
}

void Results::write(double seconds, const std::vector<std::size_t>& blocks) const {
  Json json{{"verb", "batch"},
            {"scene", scene_.name},
            {"cases", table_.rows.size()},
            {"done", ended() - failed()},
            {"failed", failed()},
            {"keys", table_.keys}};
  json["quantities"] = Json::object();
  for (const std::string& name : columns(outcomes_)) {
    const auto known = quantities_.find(name);
    json["quantities"][name] = known != quantities_.end()
                                   ? Json{{"title", known->second.title}, {"unit", known->second.unit}}
                                   : Json{{"title", name}, {"unit", nullptr}}; // of a probe, in SI units
  }
  json["warnings"] = Json::array();
  for (const Trouble& one : troubles(true))
    json["warnings"].push_back({{"name", one.kind},
                                {"message", one.message},
                                {"case", table_.rows[one.first].name},
                                {"cases", one.cases}});
  json["seconds"] = seconds;
  json["blocks"] = blocks;
  json["shard"] = shard_ ? Json{shard_->index, shard_->count} : Json();
  json["origin"] = origin_;
  json["versions"] = io::versions();
  json["files"] = file_names;
  if (dim_)
    io::replace_file(folder_ / scene_file, scene::echo(scene_, *dim_));
  io::replace_file(folder_ / table_file, table_text());
  std::error_code none; // the page of earlier results
  if (io::is_drawn(folder_ / "report.html"))
    std::filesystem::remove(folder_ / "report.html", none);
  io::replace_file(folder_ / manifest_file, io::lines(json));
}

std::string packed(const std::vector<std::pair<std::size_t, Outcome>>& outcomes) {
  Json all = Json::array();
  for (const auto& [number, outcome] : outcomes) {
    Json numbers = Json::array();
    for (const auto& [name, value] : outcome.numbers)
      numbers.push_back({name, fmt::format("{:.17g}", value)}); // JSON has no NaN
    all.push_back({number, outcome.steps, outcome.reason, outcome.interrupted, numbers, outcome.warnings});
  }
  return all.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::vector<std::pair<std::size_t, Outcome>> unpacked(const std::string& text) {
  std::vector<std::pair<std::size_t, Outcome>> outcomes;
  for (const Json& one : Json::parse(text)) {
    Outcome outcome{.steps = one.at(1), .reason = one.at(2), .interrupted = one.at(3)};
    outcome.warnings = one.at(5).get<std::map<std::string, std::string>>();
    for (const Json& number : one.at(4))
      outcome.numbers.emplace_back(number.at(0),
                                   std::strtod(number.at(1).get<std::string>().c_str(), nullptr));
    outcomes.emplace_back(one.at(0), std::move(outcome));
  }
  return outcomes;
}

} // namespace signorini::batch
