// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/reader.h"
#include "base/error.h"
#include "base/text.h"
#include "scene/expression.h"
#include "scene/key_reference.h"
#include "scene/kinds.h"
#include "scene/table.h"
#include <algorithm>
#include <cctype>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <functional>
#include <sstream>

namespace signorini::scene {
namespace {

/// Text of a TOML value for messages, on one line of at most 60 bytes.
std::string value_text(const toml::node& node) {
  constexpr std::size_t most = 60;
  std::string text;
  if (const auto* number = node.as_floating_point()) {
    text = fmt::format("{}", number->get());
    if (text.find_first_not_of("-0123456789") == std::string::npos)
      text += ".0";
  } else if (const auto* string = node.as_string()) {
    text = '"' + string->get() + '"';
    std::ranges::replace_if(text, [](unsigned char c) { return std::iscntrl(c); }, ' ');
  } else if (const toml::array* array = node.as_array()) {
    for (const toml::node& entry : *array)
      text += (text.empty() ? "" : ", ") + value_text(entry);
    text = '[' + text + ']';
  } else if (const toml::table* table = node.as_table()) {
    for (const auto& [key, value] : *table)
      text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", std::string_view(key), value_text(value));
    text = '{' + text + '}';
  } else {
    std::ostringstream out;
    node.visit([&](const auto& n) { out << n; });
    text = out.str();
  }
  if (text.size() <= most)
    return text;
  std::size_t end = most - 3;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) // do not split a UTF-8 character
    --end;
  return text.substr(0, end) + "...";
}

/// Writes a value as TOML. `absolute`: makes paths of files absolute.
std::string toml_text(const toml::node& node,
                      const std::function<std::string(const std::string&)>& absolute) {
  std::vector<std::string> entries;
  if (const toml::array* array = node.as_array()) {
    for (const toml::node& entry : *array)
      entries.push_back(toml_text(entry, absolute));
    return fmt::format("[{}]", fmt::join(entries, ", "));
  }
  if (const toml::table* table = node.as_table()) {
    for (const auto& [key, value] : *table) {
      const bool path = (key.str() == "file" || key.str() == "run") && value.is_string();
      entries.push_back(
          fmt::format("{} = {}", kind::written(std::string(key.str())),
                      path ? kind::written(absolute(value.ref<std::string>())) : toml_text(value, absolute)));
    }
    return fmt::format("{{ {} }}", fmt::join(entries, ", "));
  }
  std::ostringstream out;
  out << toml::toml_formatter{node};
  return out.str();
}

/// Adds the changes of a table to a list. `path`: of the keys so far, with a dot at its end.
void add_changes(const toml::table& table, const std::string& path,
                 const std::function<std::string(const std::string&)>& absolute,
                 std::vector<Change>& changes) {
  for (const auto& [key, value] : table) {
    const std::string full = path + std::string(key.str());
    const toml::table* inner = value.as_table();
    if (inner && key.str().find('.') == std::string_view::npos && !inner->contains("file"))
      add_changes(*inner, full + ".", absolute, changes);
    else
      changes.push_back({full, toml_text(value, absolute)});
  }
}

bool on_one_line(const std::string& text) {
  return std::ranges::none_of(text, [](unsigned char c) { return std::iscntrl(c); });
}

} // namespace

std::string Reader::full(const std::string& key) const {
  return path_.empty() ? key : key.empty() ? path_ : path_ + "." + key;
}

void Reader::fail(const std::string& key, const std::string& problem) const {
  const toml::node* found = key.empty() ? nullptr : table_.get(key);
  const toml::node& place = found ? *found : table_;
  // Neither the root table nor a value of --set has a line.
  const auto line = !found && path_.empty() ? 0 : place.source().begin.line;
  const std::string file = source_.file.string();
  throw UserError(line > 0 ? fmt::format("{}:{}: {}: {}", file, line, full(key), problem)
                           : fmt::format("{}{}: {}", found || !path_.empty() ? "--set " : file + ": ",
                                         full(key), problem));
}

bool Reader::has(const std::string& key) {
  known_.insert(key);
  return table_.contains(key);
}

const toml::node& Reader::node(const std::string& key) {
  known_.insert(key);
  const toml::node* found = table_.get(key);
  if (!found) {
    // If a misspelt key explains the missing one, report that.
    for (const auto& [other, value] : table_)
      if (const std::string name{other.str()};
          !known_.contains(name) && edit_distance(name, key) <= (key.size() > 4 ? 2 : 1))
        fail(name, fmt::format("unknown key; did you mean \"{}\"?", key));
    fail(key, "missing, but required");
  }
  return *found;
}

double Reader::to_number(const toml::node& node, const std::string& key, const Limits& limits) const {
  const auto value = node.value<double>();
  const bool number = value && node.is_number();
  if (!number || !limits.contain(*value))
    fail(key, fmt::format("found {}; expected a number{} ({}){}", value_text(node), limits.range(),
                          limits.unit.empty() ? "no unit" : limits.unit,
                          !number || std::isfinite(*value) ? "" : " that is finite"));
  return *value;
}

double Reader::number(const std::string& key, const Limits& limits) {
  return to_number(node(key), key, limits);
}

int Reader::integer(const std::string& key, int least, int greatest) {
  const auto value = node(key).as_integer();
  if (!value || value->get() < least || value->get() > greatest)
    fail(key, fmt::format("found {}; expected a whole number from {} to {}", value_text(node(key)), least,
                          greatest));
  return static_cast<int>(value->get());
}

std::string Reader::text(const std::string& key) {
  const auto value = node(key).as_string();
  if (!value || value->get().empty() || !on_one_line(value->get()))
    fail(key, fmt::format("found {}; expected a text on one line that is not empty", value_text(node(key))));
  return value->get();
}

std::filesystem::path Reader::followed(const std::filesystem::path& given, const std::string& key) const {
  std::error_code error;
  auto path =
      std::filesystem::weakly_canonical(std::filesystem::absolute(source_.file).parent_path() / given, error);
  if (error)
    fail(key, fmt::format("found a path that cannot be resolved ({}); give another path", error.message()));
  return path;
}

std::size_t Reader::choice(const std::string& key, const std::vector<std::string>& allowed) {
  const std::string value = text(key);
  const auto found = std::ranges::find(allowed, value);
  if (found == allowed.end()) {
    if (const std::string refused = refusal(without_numbers(full(key)), value); !refused.empty())
      fail(key, fmt::format("found \"{}\", {}", value, refused));
    fail(key, fmt::format("found \"{}\"{}; choices: {}", value, suggestion(value, allowed), list(allowed)));
  }
  return static_cast<std::size_t>(found - allowed.begin());
}

std::vector<std::size_t> Reader::choices(const std::string& key, const std::vector<std::string>& allowed) {
  const toml::array* array = node(key).as_array();
  if (!array)
    fail(key, fmt::format("found {}; expected a list of names from {}, or [] for none", value_text(node(key)),
                          list(allowed)));
  std::vector<std::size_t> found;
  for (const toml::node& entry : *array) {
    const auto name = entry.value<std::string>();
    const auto place = std::ranges::find(allowed, name.value_or(""));
    if (place == allowed.end())
      fail(key, fmt::format("found {}{}; choices: {}", value_text(entry),
                            name ? suggestion(*name, allowed) : "", list(allowed)));
    const auto number = static_cast<std::size_t>(place - allowed.begin());
    if (std::ranges::find(found, number) == found.end())
      found.push_back(number);
  }
  return found;
}

std::vector<double> Reader::numbers(const std::string& key, const Limits& limits) {
  const toml::array* array = node(key).as_array();
  if (!array || array->size() < 2 || array->size() > 3)
    fail(key, fmt::format("found {}; expected an array of one number per space dimension ({})",
                          value_text(node(key)), limits.unit.empty() ? "no unit" : limits.unit));
  std::vector<double> values;
  for (const toml::node& entry : *array)
    values.push_back(to_number(entry, key, limits));
  return values;
}

std::vector<double> Reader::number_or_numbers(const std::string& key, const Limits& limits) {
  if (node(key).is_array())
    return numbers(key, limits);
  return {number(key, limits)};
}

bool Reader::flag(const std::string& key) {
  const auto* value = node(key).as_boolean();
  if (!value)
    fail(key, fmt::format("found {}; expected true or false", value_text(node(key))));
  return value->get();
}

std::vector<Change> Reader::changes(const std::string& key) {
  const toml::table* table = node(key).as_table();
  if (!table || table->empty())
    fail(key, fmt::format("found {}; expected a table of keys and their values, such as "
                          "{{ \"initial.velocity\" = [\"1\", \"0\"] }}",
                          value_text(node(key))));
  std::vector<Change> changes;
  add_changes(*table, "", [&](const std::string& given) { return followed(given, key).string(); }, changes);
  return changes;
}

namespace {

/// Units that a key's values may have in tables: the key's unit, or none if it is not a plain unit.
std::vector<std::string> units(const std::string& key) {
  const auto line = std::ranges::find(keys(), without_numbers(key), &KeyLine::name);
  return line != keys().end() && unit(line->unit) ? std::vector{line->unit} : std::vector<std::string>();
}

} // namespace

Expression Reader::series(const toml::table& table, const std::string& key, std::optional<double> end) const {
  if (!end)
    fail(key, fmt::format("found {}; expected expressions of position only, without t", value_text(table)));
  Reader in(table, full(key), source_);
  if (!in.has("column") && !in.has("file"))
    in.refuse();
  const std::string column = in.text("column");
  const std::filesystem::path given = in.text("file");
  in.finish();
  const std::filesystem::path file = followed(given, key);
  std::string hint;
  const auto made = [&] {
    try {
      const std::string content = source_.open(file);
      hint = unit_hint(read_column(content, column, units(full(key))));
      return TimeSeries(content, column);
    } catch (const UserError& problem) {
      fail(key, fmt::format("{}: {}", given.string(), problem.what()));
    }
  }();
  constexpr double rounding = 1e-9;
  if (made.begin() > rounding * *end || made.end() < (1 - rounding) * *end)
    fail(key, fmt::format("{}: found times from {:.6g} to {:.6g} s; expected times that cover the run, from "
                          "0 to {:.6g} s{}",
                          given.string(), made.begin(), made.end(), *end, hint));
  return {fmt::format("{{ file = {}, column = {} }}", kind::written(file.string()), kind::written(column)),
          made};
}

Components Reader::expressions(const std::string& key, std::optional<double> end, std::size_t count) {
  const toml::node& found = node(key);
  const toml::array* array = found.as_array();
  const std::string one = found.is_string() || found.is_number() ? value_text(found) : "";
  const std::string allowed =
      count > 0 ? fmt::format("an array of {} expression{}, one for each clamped component", count,
                              count == 1 ? "" : "s")
      : one.empty()
          ? "an array of one expression per space dimension, 2 in the plane and 3 in space"
          : fmt::format(
                "an array of one expression per space dimension, such as [\"0\", {0}] in the plane and "
                "[\"0\", \"0\", {0}] in space",
                one);
  if (!array || (count > 0 ? array->size() != count : array->size() < 2 || array->size() > 3))
    fail(key, fmt::format("found {}; expected {}", value_text(found), allowed));
  Components components;
  for (const toml::node& entry : *array) {
    if (const auto* string = entry.as_string(); string && on_one_line(string->get()))
      components.emplace_back(string->get());
    else if (entry.is_number())
      components.emplace_back(value_text(entry));
    else if (const toml::table* table = entry.as_table())
      components.push_back(series(*table, key, end));
    else
      fail(key, fmt::format("found {}; expected {}", value_text(entry), allowed));
  }
  require_readable(components, key, end.has_value());
  return components;
}

Expression Reader::number_or_expression(const std::string& key, const Limits& limits, double end) {
  const toml::node& found = node(key);
  if (const toml::table* table = found.as_table())
    return series(*table, key, end);
  if (const auto* string = found.as_string(); string && on_one_line(string->get())) {
    require_readable({string->get()}, key, true);
    return string->get();
  }
  return number(key, limits);
}

std::string Reader::expression(const std::string& key, bool time) {
  const std::string given = text(key);
  require_readable({given}, key, time);
  return given;
}

void Reader::require_readable(const Components& components, const std::string& key, bool time) const {
  try {
    Field(components, full(key), time);
  } catch (const UserError& error) {
    const std::string what = error.what();
    fail(key, what.substr(full(key).size() + 2));
  }
}

Reader Reader::table(const std::string& key) {
  const toml::table* table = node(key).as_table();
  if (!table)
    fail(key, fmt::format("found {}; expected a table", value_text(node(key))));
  return {*table, full(key), source_};
}

std::vector<Reader> Reader::tables(const std::string& key, bool needed) {
  std::vector<Reader> readers;
  if (!has(key))
    return readers;
  const toml::array* array = node(key).as_array();
  if (!array || !((array->empty() && !needed) || array->is_homogeneous<toml::table>()))
    fail(key, fmt::format("found {}; expected a list of tables, [{{ ... }}], or tables headed [[{}]]",
                          value_text(node(key)), full(key)));
  for (std::size_t i = 0; i < array->size(); ++i)
    readers.emplace_back(*array->get(i)->as_table(), fmt::format("{}[{}]", full(key), i), source_);
  return readers;
}

void Reader::refuse() const {
  const std::set<std::string> choosing{"model", "law", "type", "kind"};
  for (const auto& [key, value] : table_) {
    const std::string name{key.str()};
    if (known_.contains(name))
      continue;
    const std::string chosen = choosing.contains(name) ? value.value_or(std::string()) : "";
    if (const std::string refused = refusal(without_numbers(full(name)), chosen); !refused.empty())
      fail(name, refused);
  }
}

void Reader::finish() const {
  for (const auto& [key, value] : table_) {
    const std::string name{key.str()};
    if (known_.contains(name))
      continue;
    const std::vector<std::string> names(known_.begin(), known_.end());
    const std::string near = nearest(name, names);
    fail(name, fmt::format("unknown key{}; keys here: {}",
                           near.empty() ? "" : fmt::format(", did you mean \"{}\"?", near), list(names)));
  }
}

} // namespace signorini::scene
