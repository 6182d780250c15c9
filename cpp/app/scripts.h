// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <span>
#include <string_view>
#include <vector>

namespace signorini::app {

/// A verb that runs a script of postprocess/, with its options.
struct ScriptVerb {
  const char *name, *text;
  std::vector<const char*> options;
};

const std::vector<ScriptVerb>& script_verbs();

/// Whether the word is a verb of the command line that a Python script carries out.
bool is_script_verb(std::string_view word);

/// Replaces this process by python3 with the script of the verb words[0]; its arguments are all other words,
/// ended by a null pointer. Output and exit status are the script's. Call it before MPI starts, which does
/// not support it afterwards. Throws UserError if it fails.
[[noreturn]] void become_script(std::span<char* const> words);

} // namespace signorini::app
