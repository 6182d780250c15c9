// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <memory>
#include <string>
#include <vector>

namespace signorini::scene {

struct Scene;

/// A changed key of a scenario.
struct Change {
  std::string key;   ///< path of the key, as --set takes it
  std::string value; ///< text of the value in TOML
};

/// One table [[scenario]]: changed keys of the scene, under which a control is to be good too; docs/method.md
/// section 3.
struct Scenario {
  std::string name;                     ///< name in tables, unique
  double weight = 1;                    ///< weight relative to those of the other scenarios
  std::vector<Change> set{};            ///< empty: the scene itself
  std::shared_ptr<const Scene> scene{}; ///< scene with the changes, without output; set by parse()
};

} // namespace signorini::scene
