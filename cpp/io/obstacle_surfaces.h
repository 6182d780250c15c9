// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/pairs.h"
#include "io/output_folder.h"
#include "io/surface_motion.h"
#include <span>

namespace signorini::io {

/// Writes surfaces.h5: the parts of the obstacles' surfaces near the body, at `times` (s). `body`: box (m)
/// that contains the body at all times; `places`: of each obstacle at these times. Of a contact with
/// contact.against, whose surfaces are parts of the body, only the candidates are written. `vtkhdf`: whether
/// obstacles.vtkhdf is written too, with all surfaces as one grid over time. Throws OutputFailure.
/// Collective.
void write_obstacle_surfaces(const OutputFolder& folder, const contact::ContactPairs& pairs,
                             std::span<const double> times, const contact::Box& body,
                             const std::vector<Places>& places, bool vtkhdf);

} // namespace signorini::io
