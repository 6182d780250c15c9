// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/obstacle_surface.h"
#include "contact/pairs.h"
#include "io/output_folder.h"
#include <span>

namespace signorini::io {

/// Writes surfaces.h5: the surfaces of the obstacles at `times` (s) around a body that stays within the box
/// `body`. Collective. Throws OutputFailure.
void write_surfaces(const OutputFolder& folder, const contact::ContactPairs& pairs,
                    std::span<const double> times, const contact::Box& body);

} // namespace signorini::io
