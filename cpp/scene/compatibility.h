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
  std::string on;                      ///< empty: the body
  std::vector<std::string> components; ///< empty: all
  bool constant_in_time = false;
  double step = 0;      ///< length of the control's own intervals, s; 0: the time steps
  double time_step = 0; ///< s; 0: varying
  double end = 0;       ///< s
};
/// Reads the keys of the control; absent if the text is no resolved scene with a control.
std::optional<ControlKeys> control_keys(const std::string& scene);

/// A key in which two problems differ, as "key = value" of the first and of the second.
struct Difference {
  std::string first, second;
};
/// Returns the first difference between two resolved scenes (echo()) in the keys that pose the problem and
/// those that matter to `besides`; empty texts if there is none.
Difference difference(const std::string& first, const std::string& second, Part besides = Part::problem);

} // namespace signorini::scene
