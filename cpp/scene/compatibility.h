// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/key_reference.h"
#include <optional>
#include <string>
#include <vector>

namespace signorini::scene {

/// Keys of a resolved scene that define how its control acts and on which intervals it is constant.
struct ControlKeys {
  double scale = 1;
  std::string on;                      ///< group where the control acts; empty: the body
  std::vector<std::string> components; ///< components in which the control acts; empty: all
  bool constant_in_time = false;
  double step = 0;      ///< length of the intervals on which the control is constant, s; 0: the time steps
  double time_step = 0; ///< length of the time steps, s; 0: varying
  double end = 0;       ///< end of the motion, s
};
/// Reads the keys of the control from the text of a resolved scene; absent if the text is not TOML or has no
/// control or end time.
std::optional<ControlKeys> control_keys(const std::string& scene);

/// A key in which two scenes differ.
struct Difference {
  std::string first, second; ///< "key = value", or "no key", in the first and in the second scene
};
/// Returns the first difference between two resolved scenes, as echo() writes them. Compares the keys that
/// define the problem and the keys that affect the part `besides`. Empty texts if there is no difference.
Difference difference(const std::string& first, const std::string& second, Part besides = Part::problem);

} // namespace signorini::scene
