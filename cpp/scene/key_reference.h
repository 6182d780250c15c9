// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace signorini::scene {

/// Part of a computation that a key affects: the problem that a scene poses; the search for its solution,
/// which may continue from a checkpoint; the measurements of a study, of seconds or memory; or none of these.
/// Paths have `none`: they locate a mesh or a motion but do not define it.
enum class Part { problem, search, measurement, none };

/// A key of the scene, as the reference describes it; texts are Markdown.
struct KeyLine {
  std::string name;  ///< such as material.viscosity.bulk, without the numbers of tables
  std::string value; ///< admissible values, with limits
  std::string unit;
  std::string fallback;        ///< default, or "required"; empty: no effect without the key
  std::string meaning, effect; ///< effect: name in io::effects() that the key belongs to, or empty
  Part part = Part::problem;
};

/// Keys of a scene, in the order of scene.toml.
const std::vector<KeyLine>& keys();

/// Returns a key such as material[0].young or material.0.young without the numbers of tables.
std::string without_numbers(std::string_view key);

/// Reference of the keys as plain text, a paragraph each.
std::string reference();
/// Reference of the keys as the table of docs/reference/keys.md.
std::string markdown();
/// JSON Schema (draft 2020-12) of a scene.
std::string json_schema();

/// Message for an unknown key, or an unknown name as its value, that requests an effect which the model
/// lacks; empty for others. `key`: without the numbers of tables, such as contact.friction.
std::string refusal(std::string_view key, std::string_view value = {});

/// Names of the effects that refusal() refuses, as docs/modelling.md lists them.
std::vector<std::string> refused_effects();

} // namespace signorini::scene
