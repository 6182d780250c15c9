// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/digest.h"
#include "base/error.h"
#include "base/machine.h"
#include "base/overloads.h"
#include "scene/expression.h"
#include "scene/override.h"
#include "scene/schema.h"
#include "scene/spelling.h"
#include <algorithm>
#include <fstream>
#include <sstream>

namespace signorini::scene {

std::string read(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file))
    throw UserError(
        fmt::format("{}: the scene file cannot be read; allowed is the path of a TOML file", file.string()));
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

Scene parse(const std::string& text, const std::filesystem::path& file,
            const std::vector<std::string>& overrides, const ReadFile& open) {
  toml::table root;
  try {
    root = toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    throw UserError(fmt::format("{}:{}: not valid TOML: {}", file.string(), error.source().begin.line,
                                error.description()));
  }
  Scene scene;
  for (const std::string& assignment : overrides) {
    override_key(root, assignment, file);
    scene.given.push_back(without_numbers(assignment.substr(0, assignment.find('='))));
  }
  std::optional<Digest> series;
  const Source source{file, [&](const std::filesystem::path& path) {
                        std::string content = open(path);
                        (series ? *series : series.emplace()).add(content);
                        return content;
                      }};
  Reader in(root, "", source);
  scene.file = std::filesystem::absolute(file);
  scene.name = file.stem().string();
  scene.solver.memory = machine_memory() / 2;
  schema::read(in, scene);
  if (scene.output.every == 0 && !scene.time.automatic())
    scene.output.every = Output::automatic(scene.time.steps);
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
    return "with tables [[unknown]], allowed is \"guess\"";
  if (scene.mesh.file.extension() != ".geo")
    return "with a .msh, which is meshed already, allowed with a .geo and mesh.size, or \"guess\"";
  if (!scene.mesh.size || scene.mesh.automatic())
    return "without mesh.size, allowed with it, since coarse meshes are multiples of it, or \"guess\"";
  if (std::holds_alternative<DesiredRun>(scene.objective->desired))
    return "with objective.desired.run, whose motion is known on this mesh alone, allowed is \"guess\"";
  return {};
}

Scene resized(Scene scene, double size, int steps) {
  (scene.mesh.size ? *scene.mesh.size : scene.mesh.scale) = size;
  if (scene.time.automatic())
    return scene;
  scene.time.steps = steps;
  scene.time.step = scene.time.end / steps;
  return scene;
}

} // namespace signorini::scene
