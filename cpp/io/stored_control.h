// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/control_space.h"
#include <filesystem>
#include <string>

namespace signorini::io {

/// The control that an earlier search, for a control alone or with unknowns, left in a folder, on any number
/// of ranks. Read from its checkpoint.h5: on the same mesh as it was, in other steps the value in the middle
/// of each; on another mesh of the same body, with another degree or kind of values, or in fewer components,
/// interpolated (control::Interpolation) from the mesh of that run, which is set up from its scene. Without a
/// checkpoint of that run read from its control.h5, on the same mesh (nodal values of degree 1), where that
/// has a step within each interval that is needed. `scene`: the table [control] of this scene; `key`: that
/// which names the run. Collective. Throws UserError if there is none, it is damaged, its mesh file has
/// changed, it acts with another scale, on another group or body or in more components, changes in time where
/// controls of this scene do not, or ends before this run.
control::Control stored_control(const control::ControlSpace& controls, const scene::Control& scene,
                                const std::filesystem::path& folder, const std::string& key);

} // namespace signorini::io
