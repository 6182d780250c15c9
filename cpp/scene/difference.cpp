#include "scene/difference.h"
#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <map>
#include <sstream>
#include <string_view>
#include <toml++/toml.hpp>

namespace signorini::scene {

namespace {

constexpr std::array not_of_the_problem{"mesh.file",
                                        "optimizer.max_iterations",
                                        "optimizer.tolerance",
                                        "optimizer.checkpoint",
                                        "solver.memory",
                                        "trajectory.",
                                        "output.",
                                        "run.",
                                        "check."};

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
  if (std::ranges::any_of(not_of_the_problem,
                          [&](std::string_view prefix) { return key.starts_with(prefix); }))
    return;
  std::ostringstream text;
  if (const auto* number = node.as_floating_point())
    text << fmt::format("{}", number->get());
  else if (const auto* string = node.as_string())
    text << '"' << string->get() << '"';
  else
    node.visit([&](const auto& value) { text << value; });
  values[key] = text.str();
}

std::map<std::string, std::string> flat(const std::string& scene) {
  std::map<std::string, std::string> values;
  flatten(toml::parse(scene), "", values);
  return values;
}

} // namespace

Difference difference(const std::string& first, const std::string& second) {
  const auto a = flat(first), b = flat(second);
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
