// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/key_reference.h"
#include "scene/expression.h"
#include "scene/schema.h"
#include <ranges>

namespace signorini::scene {
namespace {

using schema::Entry;
using schema::Json;
using schema::KeyInfo;

/// Appends the entries of a table's keys to `lines`. `table`: properties that the keys inherit. A key of two
/// shapes of obstacle is added once.
void add(const std::vector<Entry>& entries, const std::string& path, const KeyInfo& table,
         std::vector<KeyLine>& lines) {
  for (const Entry& entry : entries) {
    const std::string name = path + entry.name;
    KeyInfo info = entry.info;
    if (!*info.effect)
      info.effect = table.effect;
    if (info.part == Part::problem)
      info.part = table.part;
    if (!entry.children.empty())
      add(entry.children, name + ".", info, lines);
    else if (std::ranges::find(lines, name, &KeyLine::name) == lines.end())
      lines.push_back({name, entry.words, info.unit,
                       info.required && entry.fallback.empty() ? "required" : entry.fallback, info.meaning,
                       info.effect, info.part});
  }
}

std::string joined(const std::string& first, const char* between, const std::string& second) {
  return first + (first.empty() || second.empty() ? "" : between) + second;
}

} // namespace

Json schema::object(const std::vector<Entry>& keys) {
  Json json{{"type", "object"},
            {"properties", Json::object()},
            {"required", Json::array()},
            {"additionalProperties", false}};
  for (const auto& [name, info, words, fallback, own, children] : keys) {
    Json& property = json["properties"][name] = own;
    if (const std::string about = joined(info.unit, ": ", info.meaning); !about.empty())
      property["description"] = about;
    if (info.required)
      json["required"].push_back(name);
  }
  return json;
}

const std::vector<KeyLine>& keys() {
  static const std::vector<KeyLine> lines = [] {
    std::vector<KeyLine> all;
    add(schema::all(), "", {}, all);
    return all;
  }();
  return lines;
}

std::string without_numbers(std::string_view key) {
  std::string plain;
  for (const auto part : std::views::split(key, '.')) {
    std::string_view name(part.begin(), part.end());
    name = name.substr(0, name.find('['));
    if (name.find_first_not_of("0123456789") != std::string_view::npos)
      plain += (plain.empty() ? "" : ".") + std::string(name);
  }
  return plain;
}

std::string reference() {
  std::string text;
  for (const KeyLine& key : keys()) {
    text += fmt::format("{}\n    {}", key.name, joined(key.value, "; ", key.unit));
    if (!key.fallback.empty())
      text += (key.fallback == "required" ? "; " : "; default: ") + key.fallback;
    if (!key.effect.empty())
      text += "; effect: " + key.effect;
    text += key.meaning.empty() ? "\n" : "\n    " + key.meaning + "\n";
  }
  std::erase(text, '`');
  return text +
         fmt::format("Expressions consist of {}, and of x, y, z (m) and t (s) where the key has them.\nIn "
                     "place of an expression in t: {{ file = \"table.csv\", column = \"name\" }}, linear "
                     "between the times in the file's column \"time\" or \"t\".\n",
                     expression_parts());
}

std::string markdown() {
  std::string text = "| key | value | default | meaning |\n|---|---|---|---|\n";
  for (const KeyLine& key : keys())
    text += fmt::format("| `{}` | {} | {} | {} |\n", key.name, joined(key.value, "; ", key.unit),
                        key.fallback, key.meaning);
  return text;
}

std::string json_schema() {
  Json json{{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "Scene of signorini"}};
  json.update(schema::object(schema::all()));
  return json.dump(2) + "\n";
}

} // namespace signorini::scene
