// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/obstacle_surface.h"
#include "contact/pairs.h"
#include "io/output_folder.h"
#include <span>

namespace signorini::io {

/// Places of an obstacle with mass at several times; empty for an obstacle without.
using Places = std::vector<contact::RigidMotion::Place>;

/// Writes surfaces.h5: the parts of the obstacles' surfaces near the body, at `times` (s). `body`: box (m)
/// that contains the body at all times; `places`: of each obstacle at these times. Of a contact with
/// contact.against, whose surfaces are parts of the body, only the candidates are written. Throws
/// OutputFailure. Collective.
void write_obstacle_surfaces(const OutputFolder& folder, const contact::ContactPairs& pairs,
                             std::span<const double> times, const contact::Box& body,
                             const std::vector<Places>& places);

} // namespace signorini::io
