// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <string>
#include <vector>

namespace signorini::app {

/// A verb of the command line and the names of its options, such as --out.
struct VerbOptions {
  std::string verb;
  std::vector<std::string> options;
};

/// Returns a bash script that completes verbs, options, folders, scenes, the keys of --set and the values of
/// these keys.
std::string bash_completion(const std::vector<VerbOptions>& verbs);

} // namespace signorini::app
