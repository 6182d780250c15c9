// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace signorini::scene {

/// What a key matters to: the problem that a scene poses; the search for its solution, which goes on from a
/// checkpoint; what a study measures, be it seconds or memory; or none of these. Paths are of the last: they
/// tell where a mesh or a motion is stored, not what it contains.
enum class Part { problem, search, measurement, none };

/// A key of the scene, as the reference tells of it; texts are Markdown.
struct KeyLine {
  std::string name;  ///< such as material.viscosity.bulk, without the numbers of tables
  std::string value; ///< what it takes, with its limits
  std::string unit;
  std::string fallback;        ///< what holds without it, or "required"; empty: without it there is no effect
  std::string meaning, effect; ///< the effect that it is part of, a name of io::effects(); may be empty
  Part part = Part::problem;
};

/// All keys, in the order of scene.toml.
const std::vector<KeyLine>& keys();

/// A key such as material[0].young or material.0.young without the numbers of tables.
std::string without_numbers(std::string_view key);

/// The keys for reading, a paragraph each.
std::string reference();
/// The keys as the table of docs/reference/keys.md.
std::string markdown();
/// JSON Schema (draft 2020-12) of a scene.
std::string json_schema();

/// The message on an unknown key, or an unknown name as its value, that asks for an effect which the model
/// lacks; empty for others. `key`: without the numbers of tables, such as contact.friction.
std::string refusal(std::string_view key, std::string_view value = {});

/// Names of all effects that refusal() knows, as docs/modelling.md lists them.
std::vector<std::string> refused_effects();

} // namespace signorini::scene
