// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/scripts.h"
#include "base/error.h"
#include "base/subprocess.h"
#include <algorithm>
#include <cerrno>
#include <fmt/format.h>
#include <stdexcept>
#include <string>
#include <system_error>
#include <unistd.h>

namespace signorini::app {
namespace {

/// Command of Python with the program that runs the script of a verb. Throws UserError if there is none.
std::vector<std::string> launcher(const char* verb) {
  try {
    return python_command("verb.py");
  } catch (const std::runtime_error& error) {
    throw UserError(fmt::format("{}: {}; install signorini completely", verb, error.what()));
  }
}

} // namespace

const std::vector<ScriptVerb>& script_verbs() {
  static const std::vector<ScriptVerb> verbs{
      {"report",
       "write a page with all results of a run, a study or a batch, or of two runs side by side",
       {"--threads", "--quiet"}},
      {"figures", "draw all figures of a run", {"--time", "--threads", "--quiet"}},
      {"plot",
       "plot the convergence of an optimization or a fit, also while it runs",
       {"--every", "--threads", "--quiet"}}};
  return verbs;
}

bool is_script_verb(std::string_view word) {
  return std::ranges::find(script_verbs(), word, &ScriptVerb::name) != script_verbs().end();
}

void become_script(std::span<char* const> words) {
  std::vector<std::string> command = launcher(words.front());
  std::vector<char*> arguments;
  for (std::string& word : command)
    arguments.push_back(word.data());
  arguments.insert(arguments.end(), words.begin(), words.end());
  execvp(arguments.front(), arguments.data());
  throw UserError(fmt::format("{}: no python3 on PATH can be started ({}); install Python 3, or add its "
                              "folder to PATH",
                              words.front(), std::generic_category().message(errno)));
}

} // namespace signorini::app
