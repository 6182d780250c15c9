// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/control_space.h"
#include <filesystem>
#include <string>

namespace signorini::io {

/// Reads the final control of an earlier search from the search's output folder; the search may have fitted
/// unknowns too. The number of ranks may differ. On the same mesh the values are read unchanged from
/// checkpoint.h5. If the time intervals differ, each present interval gets the earlier control's value at its
/// middle. On another mesh of the same body, with another degree or kind of values, or with fewer components,
/// the control is interpolated (control::Interpolation); the earlier run's mesh is then rebuilt from its
/// scene. If the folder has no checkpoint of that run, the control is read from control.h5. This requires the
/// same mesh, nodal values of degree 1, equal time steps, and a stored step within each earlier interval that
/// is used. `scene`: table [control] of the present scene; `key`: the present scene's key that names the
/// folder, for messages. Throws UserError if the control is missing or damaged, or if its mesh file has
/// changed. Throws UserError also if the control has another scale, acts on another group or body or in more
/// components, ends before the present run, or changes in time although the present one may not. Collective.
control::Control stored_control(const control::ControlSpace& controls, const scene::Control& scene,
                                const std::filesystem::path& folder, const std::string& key);

} // namespace signorini::io
