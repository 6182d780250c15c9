// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/key_reference.h"
#include <optional>

namespace signorini::scene {

/// The time step of a resolved scene, s; absent if the text is none.
std::optional<double> time_step(const std::string& scene);

/// A key in which two problems differ, as "key = value" of the first and of the second.
struct Difference {
  std::string first, second;
};
/// Returns the first difference between two resolved scenes (echo()) in the keys that pose the problem and
/// those that matter to `besides`; empty texts if there is none.
Difference difference(const std::string& first, const std::string& second, Part besides = Part::problem);

} // namespace signorini::scene
