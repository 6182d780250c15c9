// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "scene/scene.h"
#include <span>

/// The values that unknowns can have, and the tractions that they scale.
namespace signorini::scene {
struct Limits;

/// The natural limits of an unknown; on a logarithmic scale it is positive.
Limits limits(const Unknown& unknown);
/// Throws UserError unless each unknown can have its value.
void require_possible(const Scene& scene, std::span<const double> values);

/// Whether a factor of tractions is one of this: it scales all on its group.
bool scales(const Unknown& unknown, const Traction& traction);

} // namespace signorini::scene
