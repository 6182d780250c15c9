// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/compatibility.h"
#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <sstream>
#include <toml++/toml.hpp>

namespace signorini::scene {

namespace {

/// Whether the key `name`, such as material[0].young, affects the problem or the part `besides`.
bool matters(const std::string& name, Part besides) {
  const auto key = std::ranges::find(keys(), without_numbers(name), &KeyLine::name);
  return key == keys().end() || key->part == Part::problem || key->part == besides;
}

void flatten(const toml::node& node, const std::string& key, std::map<std::string, std::string>& values) {
  if (const toml::table* table = node.as_table()) {
    for (const auto& [name, child] : *table)
      flatten(child, key.empty() ? std::string(name.str()) : key + "." + std::string(name.str()), values);
    return;
  }
  if (const toml::array* array = node.as_array(); array && array->is_array_of_tables()) {
    for (std::size_t i = 0; i < array->size(); ++i)
      flatten((*array)[i], key + "[" + std::to_string(i) + "]", values);
    return;
  }
  std::ostringstream text;
  if (const auto* number = node.as_floating_point())
    text << fmt::format("{}", number->get());
  else if (const auto* string = node.as_string())
    text << '"' << string->get() << '"';
  else
    node.visit([&](const auto& value) { text << value; });
  values[key] = text.str();
}

/// Parses a scene that a run wrote. TOML must be UTF-8, but paths need not be; if parsing fails, each byte of
/// the text that is not ASCII is read as one character.
toml::table parsed(const std::string& scene) {
  try {
    return toml::parse(scene);
  } catch (const toml::parse_error&) {
    std::string escaped;
    for (const char byte : scene)
      if (static_cast<unsigned char>(byte) < 0x80)
        escaped += byte;
      else
        escaped += fmt::format("\\u{:04x}", static_cast<unsigned char>(byte));
    return toml::parse(escaped);
  }
}

std::map<std::string, std::string> posed(const std::string& scene, Part besides) {
  std::map<std::string, std::string> values;
  flatten(parsed(scene), "", values);
  values.try_emplace("mesh.model", "\"plane-strain\""); // the default
  std::erase_if(values, [&](const auto& entry) { return !matters(entry.first, besides); });
  return values;
}

} // namespace

std::optional<ControlKeys> control_keys(const std::string& scene) {
  toml::table root;
  try {
    root = parsed(scene);
  } catch (const toml::parse_error&) {
    return std::nullopt;
  }
  const toml::table* control = root["control"].as_table();
  const std::optional<double> end = root["time"]["end"].value<double>();
  if (!control || !end)
    return std::nullopt;
  ControlKeys keys{.scale = (*control)["scale"].value_or(1.0),
                   .on = (*control)["on"].value_or(std::string()),
                   .components = {},
                   .constant_in_time = (*control)["constant_in_time"].value_or(false),
                   .step = (*control)["step"].value_or(0.0),
                   .time_step = root["time"]["step"].value_or(0.0),
                   .end = *end};
  if (const toml::array* components = (*control)["components"].as_array())
    for (const toml::node& one : *components)
      keys.components.push_back(one.value_or(std::string()));
  return keys;
}

Difference difference(const std::string& first, const std::string& second, Part besides) {
  const auto a = posed(first, besides), b = posed(second, besides);
  const auto shown = [](const auto& values, const std::string& key) {
    auto found = values.find(key);
    if (found == values.end()) // perhaps a table in place of a value, or the reverse
      found = std::ranges::find_if(values, [&](const auto& entry) {
        return entry.first.starts_with(key + ".") || key.starts_with(entry.first + ".");
      });
    return found == values.end() ? "no " + key : found->first + " = " + found->second;
  };
  for (const auto* one : {&a, &b})
    for (const auto& [key, value] : *one)
      if (shown(a, key) != shown(b, key))
        return {shown(a, key), shown(b, key)};
  return {};
}

} // namespace signorini::scene
