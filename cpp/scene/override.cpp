// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/override.h"
#include "base/error.h"
#include <fmt/format.h>
#include <sstream>

namespace signorini::scene {

void override_key(toml::table& root, const std::string& assignment, const std::filesystem::path& file) {
  const auto equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0)
    throw UserError(
        fmt::format("--set: found \"{}\", allowed is key.path=value, such as mesh.size=0.25", assignment));
  const std::string path = assignment.substr(0, equals), value = assignment.substr(equals + 1);
  toml::table parsed;
  try {
    parsed = toml::parse("value = " + value);
    if (parsed.size() != 1)
      throw UserError(fmt::format("--set {}: found several lines, allowed is one value", path));
  } catch (const toml::parse_error&) {
    try {
      (void)toml::parse("# " + value);
    } catch (const toml::parse_error&) {
      throw UserError(fmt::format(
          "--set {}: found neither a value of TOML nor a text, allowed is a text on one line in UTF-8",
          path));
    }
    parsed.insert("value", value);
  }
  if (path.front() == '.' || path.back() == '.' || path.find("..") != std::string::npos)
    throw UserError(fmt::format("--set {}: the key {}, allowed are names with single dots between them",
                                assignment,
                                path.back() == '.' ? "ends in a dot" : "has an empty name before a dot"));
  toml::table* table = &root;
  std::istringstream keys(path);
  std::string key, next;
  std::getline(keys, key, '.');
  while (std::getline(keys, next, '.')) {
    toml::node* child = table->get(key);
    if (!child)
      child = &table->insert(key, toml::table{}).first->second;
    if (toml::array* array = child->as_array(); array && !array->is_homogeneous<toml::table>())
      throw UserError(
          fmt::format("--set {}: \"{}\" of {} is a list of values, set it as a whole, such as [1, 2]",
                      assignment, key, file.string()));
    if (toml::array* array = child->as_array()) {
      std::size_t index = array->size();
      if (next.empty() || next.find_first_not_of("0123456789") != std::string::npos ||
          (index = std::stoul(next.substr(0, 6))) >= array->size() || !array->get(index)->is_table() ||
          !std::getline(keys, next, '.'))
        throw UserError(fmt::format("--set {}: \"{}\" of {} is a list of {} table{}, name one by its number "
                                    "and one of its keys, such as {}.0.on=...",
                                    assignment, key, file.string(), array->size(),
                                    array->size() == 1 ? "" : "s", key));
      child = array->get(index);
    }
    table = child->as_table();
    if (!table)
      throw UserError(
          fmt::format("--set {}: \"{}\" is not a table, allowed are keys of tables", assignment, key));
    key = next;
  }
  table->insert_or_assign(key, *parsed.get("value"));
}

} // namespace signorini::scene
