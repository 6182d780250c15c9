// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <span>
#include <string_view>
#include <vector>

namespace signorini::app {

/// A verb that runs a script of postprocess/.
struct ScriptVerb {
  const char *name, *text;          ///< the verb, and its description for --help
  std::vector<const char*> options; ///< names of the verb's options
};

const std::vector<ScriptVerb>& script_verbs();

/// Whether the word is a verb of the command line that a Python script carries out.
bool is_script_verb(std::string_view word);

/// Replaces this process by python3 running the script of the verb words[0], with the other words as
/// arguments; the last element of `words` must be a null pointer. Call before MPI starts, since MPI does not
/// support it afterwards. Throws UserError if the process cannot be replaced.
[[noreturn]] void become_script(std::span<char* const> words);

} // namespace signorini::app
