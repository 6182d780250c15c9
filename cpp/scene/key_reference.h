// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace signorini::scene {

/// Part of a computation that a key affects. problem: the problem that a scene poses; search: the search for
/// its solution, which may continue from a checkpoint; measurement: run time or memory, which studies
/// measure; none: none of these. Paths have `none`, since a path locates a mesh or a motion but does not
/// define it.
enum class Part { problem, search, measurement, none };

/// Entry of the key reference: a key of scenes, with texts in Markdown.
struct KeyLine {
  std::string name;  ///< full name, such as material.viscosity.bulk, without the numbers of tables
  std::string value; ///< admissible values, with limits
  std::string unit;
  std::string fallback;        ///< default, or "required"; empty: no effect without the key
  std::string meaning, effect; ///< explanation; name of the key's effect in io::effects(), or empty
  Part part = Part::problem;
};

/// Entries of all keys of a scene, in the order of scene.toml.
const std::vector<KeyLine>& keys();

/// Removes the numbers of tables from a key: material[0].young and material.0.young give material.young.
std::string without_numbers(std::string_view key);

/// Reference of all keys as plain text, with a paragraph for each key.
std::string reference();
/// Reference of all keys as a Markdown table, that of docs/reference/keys.md.
std::string markdown();
/// JSON Schema (draft 2020-12) of a scene.
std::string json_schema();

/// Message for a key or a value that requests an effect outside the model, such as friction, or an effect of
/// the model under another name than its key; empty if no such effect is recognised. `key`: full name without
/// the numbers of tables; `value`: name given as the key's value; empty: only the key is examined.
std::string refusal(std::string_view key, std::string_view value = {});

/// Names of the effects outside the model that refusal() recognises, as docs/modelling.md lists them.
std::vector<std::string> refused_effects();

} // namespace signorini::scene
