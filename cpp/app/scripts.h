// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <span>
#include <string_view>
#include <vector>

namespace signorini::app {

/// A verb that a script of postprocess/ does, with its options.
struct ScriptVerb {
  const char *name, *text;
  std::vector<const char*> options;
};

const std::vector<ScriptVerb>& script_verbs();

/// Whether the word is one of them.
bool is_script_verb(std::string_view word);

/// Becomes python3 with the script of the verb words[0] and all other words as its arguments, ended by a null
/// pointer; what is printed and returned then is the script's. To be called before MPI starts, which does not
/// bear it afterwards. Returns only if it fails, by throwing UserError.
[[noreturn]] void become_script(std::span<char* const> words);

} // namespace signorini::app
