// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/control_space.h"
#include <filesystem>
#include <string>

namespace signorini::io {

/// Reads the control that an earlier search, for a control alone or with unknowns, left in a folder, on any
/// number of ranks. On the same mesh it is read unchanged from checkpoint.h5; in other steps it has the value
/// in the middle of each. On another mesh of the same body, with another degree or kind of values, or in
/// fewer components it is interpolated (control::Interpolation) from that run's mesh, set up from its scene.
/// Without a checkpoint of that run it is read from its control.h5, on the same mesh (nodal values of degree
/// 1), if that has a step within each interval needed. `scene`: the table [control] of this scene; `key`: the
/// scene's key that names the run. Collective. Throws UserError if there is no control, it is damaged, or its
/// mesh file has changed. Throws it, too, if the control acts with another scale, on another group or body or
/// in more components, changes in time where this scene's do not, or ends before this run.
control::Control stored_control(const control::ControlSpace& controls, const scene::Control& scene,
                                const std::filesystem::path& folder, const std::string& key);

} // namespace signorini::io
