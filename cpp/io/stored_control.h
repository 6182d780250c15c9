// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "control/control_space.h"
#include <filesystem>
#include <string>

namespace signorini::io {

/// The control that an earlier search left in a folder, on any number of ranks: of its checkpoint.h5, as it
/// was, where the steps of this run are others with the value in the middle of each; on another mesh, with
/// another degree or kind of values interpolated (control::Interpolation) from the mesh of that run, which is
/// made again from its scene. Without a checkpoint of its control.h5, on the same mesh (nodal values of
/// degree 1, linear between stored steps). `key`: that of the scene which names the run. Collective. Throws
/// UserError if there is none, or it is damaged, its mesh file has changed, it acts on a set of another
/// dimension, or it ends before this run.
control::Control stored_control(const control::ControlSpace& controls, const std::filesystem::path& folder,
                                const std::string& key);

} // namespace signorini::io
