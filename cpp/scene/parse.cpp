// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/digest.h"
#include "base/error.h"
#include "base/machine.h"
#include "base/overloads.h"
#include "scene/expression.h"
#include "scene/scene.h"
#include "scene/schema.h"
#include <algorithm>
#include <fmt/format.h>
#include <fstream>
#include <sstream>

namespace signorini::scene {

std::string read(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file))
    throw UserError(
        fmt::format("{}: the scene file cannot be read; give the path of a TOML file", file.string()));
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

namespace {

/// Applies an argument `key.path=value` of --set to a scene's table. A value that is not TOML is taken as a
/// text; an empty one, which --unset gives, removes the key. `file`: path of the scene, for messages. Throws
/// UserError.
void override_key(toml::table& root, const std::string& assignment, const std::filesystem::path& file) {
  const auto equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0)
    throw UserError(
        fmt::format("--set: found \"{}\"; expected key.path=value, such as mesh.size=0.25", assignment));
  const std::string path = assignment.substr(0, equals), value = assignment.substr(equals + 1);
  toml::table parsed;
  try {
    parsed = toml::parse("value = " + value);
    if (parsed.size() != 1)
      throw UserError(fmt::format("--set {}: found several lines; give one value", path));
  } catch (const toml::parse_error&) {
    try {
      (void)toml::parse("# " + value);
    } catch (const toml::parse_error&) {
      throw UserError(fmt::format(
          "--set {}: the value is neither TOML nor plain text; give text on one line in UTF-8", path));
    }
    parsed.insert("value", value);
  }
  if (path.front() == '.' || path.back() == '.' || path.find("..") != std::string::npos)
    throw UserError(fmt::format("--set {}: the key {}; expected names with single dots between them",
                                assignment,
                                path.back() == '.' ? "ends in a dot" : "has an empty name before a dot"));
  const std::string option = value.empty() ? "--unset " + path : "--set " + assignment;
  toml::table* table = &root;
  std::istringstream keys(path);
  std::string key, next;
  std::getline(keys, key, '.');
  while (std::getline(keys, next, '.')) {
    toml::node* child = table->get(key);
    if (!child)
      child = &table->insert(key, toml::table{}).first->second;
    if (toml::array* array = child->as_array(); array && !array->is_homogeneous<toml::table>())
      throw UserError(fmt::format("{}: \"{}\" of {} is a list of values; set the whole list, such as [1, 2]",
                                  option, key, file.string()));
    if (toml::array* array = child->as_array()) {
      const bool number = !next.empty() && next.find_first_not_of("0123456789") == std::string::npos;
      const std::size_t index = number ? std::stoul(next.substr(0, 6)) : array->size();
      const bool there = index < array->size() && array->get(index)->is_table(), removes = value.empty();
      if (there && removes && keys.eof()) {
        array->erase(array->cbegin() + static_cast<std::ptrdiff_t>(index));
        if (array->empty())
          table->erase(key);
        return;
      }
      if (!there || !std::getline(keys, next, '.'))
        throw UserError(fmt::format("{}: \"{}\" of {} is a list of {} table{}; name one by its number{}",
                                    option, key, file.string(), array->size(), array->size() == 1 ? "" : "s",
                                    removes ? fmt::format(", such as {}.0", key)
                                            : fmt::format(", and its key, such as {}.0.on=...", key)));
      child = array->get(index);
    }
    table = child->as_table();
    if (!table)
      throw UserError(fmt::format("{}: \"{}\" is not a table; name a key of a table", option, key));
    key = next;
  }
  if (!value.empty())
    table->insert_or_assign(key, *parsed.get("value"));
  else if (table->erase(key) == 0)
    throw UserError(fmt::format("--unset {}: {} has no such key; name one that it has", path, file.string()));
}

/// Reads all tables of a scene.
Scene read_tables(const toml::table& root, const Source& source) {
  Reader in(root, "", source);
  Scene scene;
  scene.file = std::filesystem::absolute(source.file);
  scene.name = source.file.stem().string();
  scene.solver.memory = machine_memory() / 2;
  schema::read(in, scene);
  if (scene.output.every == 0 && !scene.time.automatic() && !scene.time.until_bounce)
    scene.output.every = Output::automatic(scene.time.steps);
  return scene;
}

/// Returns the scene with the changes of its i-th scenario, and without output. Throws UserError.
std::shared_ptr<const Scene> changed(const toml::table& given, const Scene& scene, std::size_t i,
                                     const Source& source) {
  const auto line = given["scenario"][i].node()->source().begin.line;
  toml::table root = given;
  root.erase("scenario");
  try {
    for (const Change& change : scene.scenarios[i].set)
      override_key(root, change.key + "=" + change.value, source.file);
    if (toml::table* objective = root["objective"].as_table())
      objective->erase("exponent");
    auto made = std::make_shared<Scene>(read_tables(root, source));
    made->output.fields.clear();
    made->output.tables.clear();
    made->output.probes.clear();
    return made;
  } catch (const UserError& error) {
    std::string what = error.what();
    for (const std::string& before : {std::string("--set "), source.file.string() + ": "})
      if (what.starts_with(before))
        what.erase(0, before.size());
    throw UserError(fmt::format("{}{}: {}.set: {}", source.file.string(),
                                line > 0 ? fmt::format(":{}", line) : "", scenario_key(i), what));
  }
}

} // namespace

Scene parse(const std::string& text, const std::filesystem::path& file,
            const std::vector<std::string>& overrides, const ReadFile& open) {
  toml::table root;
  try {
    root = toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    throw UserError(fmt::format("{}:{}: not valid TOML: {}", file.string(), error.source().begin.line,
                                error.description()));
  }
  for (const std::string& assignment : overrides)
    override_key(root, assignment, file);
  std::optional<Digest> series;
  const Source source{file, [&](const std::filesystem::path& path) {
                        std::string content = open(path);
                        (series ? *series : series.emplace()).add(content);
                        return content;
                      }};
  Scene scene = read_tables(root, source);
  for (std::size_t i = 0; i < scene.scenarios.size(); ++i)
    scene.scenarios[i].scene = changed(root, scene, i, source);
  for (const std::string& assignment : overrides)
    scene.given.push_back(without_numbers(assignment.substr(0, assignment.find('='))));
  if (series)
    scene.digest_of_series = series->text();
  return scene;
}

int Output::automatic(int steps) {
  int every = 1;
  for (int digit = 0; (steps - 1) / every + 1 > most_frames; digit = (digit + 1) % 3)
    every = digit == 1 ? every / 2 * 5 : every * 2;
  return every;
}

std::string contact_key(const std::vector<Contact>& contacts, std::size_t i) {
  return contacts.size() == 1 ? "contact" : fmt::format("contact[{}]", i);
}

std::string clamp_key(const std::vector<Clamp>& clamps, std::size_t i) {
  return clamps.size() == 1 ? "clamp" : fmt::format("clamp[{}]", i);
}

std::string scenario_key(std::size_t i) { return fmt::format("scenario[{}]", i); }
std::string unknown_key(std::size_t i) { return fmt::format("unknown[{}]", i); }
std::string measurement_key(std::size_t i) { return fmt::format("measurement[{}]", i); }

std::vector<Component> components(int dim) {
  std::vector<Component> all{Component::x, Component::y, Component::z};
  all.resize(static_cast<std::size_t>(dim));
  return all;
}

bool vanishes(const Components& components) {
  return std::ranges::all_of(components, [](const Expression& expression) {
    return expression.shift == 0 && (expression.text == "0" || expression.text == "0.0");
  });
}

bool moves(const Obstacle& obstacle) {
  const auto varies = [](const Components& components) {
    return Field(components, "obstacle", true).depends_on_time();
  };
  return std::visit(
      Overloads{[&](const HalfSpace& plane) { return varies(plane.point); },
                [&](const Ball& ball) { return varies(ball.center) || varies({ball.radius}); },
                [&](const Cylinder& cylinder) { return varies(cylinder.point) || varies({cylinder.radius}); },
                [&](const SignedDistance& level_set) { return varies({level_set.distance}); }},
      obstacle);
}

bool moves(const Contact& contact) { return contact.obstacle && moves(*contact.obstacle); }

bool rests(const Control& control) {
  const auto all = [](const std::optional<std::vector<double>>& bound, auto&& allows) {
    return !bound || std::ranges::all_of(*bound, allows);
  };
  return !control.stored && (!control.initial || vanishes(*control.initial)) &&
         all(control.lower, [](double x) { return x <= 0; }) &&
         all(control.upper, [](double x) { return x >= 0; });
}

std::string no_coarse_start(const Scene& scene) {
  if (!scene.unknowns.empty())
    return "with tables [[unknown]]; set it to \"guess\"";
  if (scene.mesh.meshed())
    return "with a mesh, from which no coarser meshes can be made; use a .geo and mesh.size, or set "
           "optimizer.start to \"guess\"";
  if (!scene.mesh.size || scene.mesh.automatic())
    return "without mesh.size, whose multiples are the sizes of the coarse meshes; give mesh.size, or set "
           "optimizer.start to \"guess\"";
  if (std::holds_alternative<DesiredRun>(scene.objective->desired))
    return "with objective.desired.run, whose motion is known on this mesh only; set it to \"guess\"";
  return {};
}

Scene resized(Scene scene, double size, int steps) {
  for (Scenario& scenario : scene.scenarios)
    scenario.scene = std::make_shared<const Scene>(resized(*scenario.scene, size, steps));
  (scene.mesh.size ? *scene.mesh.size : scene.mesh.scale) = size;
  if (scene.time.automatic())
    return scene;
  scene.time.steps = steps;
  scene.time.step = scene.time.end / steps;
  return scene;
}

namespace {

Components zero(std::size_t size) { return Components(size, "0"); }

template <class T>
void fill(std::optional<T>& given, const T& otherwise) {
  if (!given)
    given = otherwise;
}

} // namespace

std::string echo(const Scene& scene, int dim) {
  Scene whole = scene;
  for (Clamp& clamp : whole.clamps) {
    fill(clamp.components, components(dim));
    fill(clamp.value, zero(clamp.components->size()));
  }
  const Components still = zero(static_cast<std::size_t>(dim));
  // With moving clamps the default is their motion at the start, which a field of expressions cannot state.
  if (std::ranges::all_of(whole.clamps, [](const Clamp& clamp) { return vanishes(*clamp.value); })) {
    if (!whole.initial.equilibrium)
      fill(whole.initial.displacement, still);
    if (!whole.initial.drop)
      fill(whole.initial.velocity, still);
  }
  if (whole.control) {
    fill(whole.control->components, components(dim));
    if (!whole.control->stored)
      fill(whole.control->initial, still);
  }
  return schema::write(whole);
}

} // namespace signorini::scene
