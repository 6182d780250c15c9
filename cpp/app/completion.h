// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <string>
#include <vector>

namespace signorini::app {

/// A verb of the command line with its options, such as --out.
struct VerbOptions {
  std::string verb;
  std::vector<std::string> options;
};

/// Returns a script with which bash completes verbs, options, folders, scenes, the keys of --set and their
/// choices.
std::string bash_completion(const std::vector<VerbOptions>& verbs);

} // namespace signorini::app
