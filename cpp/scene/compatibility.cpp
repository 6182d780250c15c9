#include "scene/compatibility.h"
#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <sstream>
#include <string_view>
#include <toml++/toml.hpp>

namespace signorini::scene {

namespace {

/// Keys that do not define the problem. Paths are among them: they tell where a mesh or a motion is stored,
/// not what it contains.
constexpr Keys not_of_the_problem{"mesh.file",   "objective.desired.run",
                                  "optimizer.",  "solver.memory",
                                  "trajectory.", "output.",
                                  "run.",        "check.",
                                  "exact."};

bool among(Keys keys, std::string_view key) {
  return std::ranges::any_of(keys, [&](std::string_view prefix) { return key.starts_with(prefix); });
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

std::map<std::string, std::string> posed(const std::string& scene, Keys besides) {
  std::map<std::string, std::string> values;
  flatten(toml::parse(scene), "", values);
  std::erase_if(values, [&](const auto& entry) {
    return among(not_of_the_problem, entry.first) && !among(besides, entry.first);
  });
  return values;
}

} // namespace

std::string problem(const std::string& scene, Keys besides) {
  std::string text;
  for (const auto& [key, value] : posed(scene, besides))
    text += key + " = " + value + '\n';
  return text;
}

Difference difference(const std::string& first, const std::string& second, Keys besides) {
  const auto a = posed(first, besides), b = posed(second, besides);
  const auto shown = [](const auto& values, const std::string& key) {
    const auto found = values.find(key);
    return found == values.end() ? "no " + key : key + " = " + found->second;
  };
  for (const auto* one : {&a, &b})
    for (const auto& [key, value] : *one)
      if (shown(a, key) != shown(b, key))
        return {shown(a, key), shown(b, key)};
  return {};
}

} // namespace signorini::scene
