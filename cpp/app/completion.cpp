// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/completion.h"
#include "app/scripts.h"
#include "scene/key_reference.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace signorini::app {
namespace {

/// Admissible values of a key whose value is one of a few words, as quoted in the key reference; else empty.
std::vector<std::string> choices(const scene::KeyLine& key) {
  if (key.value.starts_with("`true`"))
    return {"true", "false"};
  std::vector<std::string> words;
  if (!key.value.starts_with('`'))
    return words;
  for (std::size_t open = key.value.find('"'); open != std::string::npos;) {
    const std::size_t close = key.value.find('"', open + 1);
    words.push_back(key.value.substr(open + 1, close - open - 1));
    open = key.value.find('"', close + 1);
  }
  return words;
}

constexpr const char* script = R"(# Completion of signorini in bash: source <(signorini completion)
_signorini() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} words= key=
  if [ "$COMP_CWORD" -eq 1 ]; then
    mapfile -t COMPREPLY < <(compgen -W "{verbs} --help --version" -- "$word")
    return
  fi
  # bash takes the = of key=value for a word of its own.
  if [ "$word" = "=" ]; then key=$before word=
  elif [ "$before" = "=" ]; then key=${{COMP_WORDS[COMP_CWORD-2]}}
  fi
  if [ -n "$key" ]; then
    case $key in
{choices}    esac
  elif [ "$before" = --set ]; then
    compopt -o nospace 2>/dev/null
    words="{keys}"
  elif [ "$before" = --out ]; then
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -d -- "$word")
    return
  elif [ "${{word#-}}" = "$word" ] && [[ " {of_folders} " = *" ${{COMP_WORDS[1]}} "* ]]; then
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -d -- "$word")
    return
  elif [ "${{word#-}}" != "$word" ]; then
    case ${{COMP_WORDS[1]}} in
{options}    esac
  else
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -f -X '!*.toml' -- "$word"; compgen -d -- "$word")
    return
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
}}
complete -F _signorini signorini
)";

} // namespace

std::string bash_completion(const std::vector<VerbOptions>& verbs) {
  std::vector<std::string> names, keys;
  std::string options, values;
  for (const auto& [verb, own] : verbs) {
    names.push_back(verb);
    options += fmt::format("    {}) words=\"{}\" ;;\n", verb, fmt::join(own, " "));
  }
  for (const scene::KeyLine& key : scene::keys()) {
    keys.push_back(key.name + "=");
    if (const std::vector<std::string> words = choices(key); !words.empty())
      values += fmt::format("    {}) words=\"{}\" ;;\n", key.name, fmt::join(words, " "));
  }
  std::vector<std::string> of_folders;
  for (const ScriptVerb& verb : script_verbs())
    of_folders.emplace_back(verb.name);
  return fmt::format(script, fmt::arg("of_folders", fmt::join(of_folders, " ")),
                     fmt::arg("verbs", fmt::join(names, " ")), fmt::arg("choices", values),
                     fmt::arg("keys", fmt::join(keys, " ")), fmt::arg("options", options));
}

} // namespace signorini::app
