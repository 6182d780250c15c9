// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/scripts.h"
#include "base/error.h"
#include "base/subprocess.h"
#include "version.h"
#include <algorithm>
#include <cerrno>
#include <fmt/format.h>
#include <stdexcept>
#include <string>
#include <system_error>
#include <unistd.h>

namespace signorini::app {
namespace {

/// File name of the launcher, a Python program that runs the script of a verb.
constexpr char launcher[] = "verb.py";

struct Launcher {
  std::filesystem::path file;
  bool installed;
};

/// Finds the launcher in the build folder or in the installation. Throws UserError if there is none.
Launcher find_launcher(const char* verb) {
  const std::filesystem::path folder = own_folder(); // in a build it has a link to the scripts of its sources
  std::string tried;
  for (const auto& [at, installed] :
       {std::pair{folder / "postprocess", false}, std::pair{folder / "../share/signorini/postprocess", true},
        std::pair{std::filesystem::path(version::data) / "signorini/postprocess", true}}) {
    const std::filesystem::path file = (at / launcher).lexically_normal();
    if (access(file.c_str(), R_OK) == 0)
      return {file, installed};
    tried += (tried.empty() ? "" : ", ") + file.string();
  }
  throw UserError(fmt::format("{}: the scripts of this verb were not found at {}; install signorini "
                              "completely",
                              verb, tried));
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
  const Launcher found = find_launcher(words.front());
  std::string python = "python3", leave = "-B", file = found.file.string();
  std::vector<char*> arguments{python.data()};
  if (found.installed) // leaves no compiled files there, which the package does not list
    arguments.push_back(leave.data());
  arguments.push_back(file.data());
  arguments.insert(arguments.end(), words.begin(), words.end());
  execvp(python.c_str(), arguments.data());
  throw UserError(fmt::format("{}: no python3 on PATH can be started ({}); install Python 3, or add its "
                              "folder to PATH",
                              words.front(), std::generic_category().message(errno)));
}

} // namespace signorini::app
