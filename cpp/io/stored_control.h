#pragma once
#include "control/control.h"
#include <filesystem>
#include <string>

namespace signorini::io {

/// The control that an earlier search left in a folder, on the same mesh and any number of ranks: of its
/// checkpoint.h5, as it was, else of its control.h5 (nodal values of degree 1, linear between stored steps).
/// Where the steps of this run are others each has the value in its middle. `key`: that of the scene which
/// names the run. Collective. Throws UserError if there is none, or it is damaged, of another mesh or kind,
/// or ends before this run.
control::Control stored_control(const control::ControlSpace& controls, const std::filesystem::path& folder,
                                const std::string& key);

} // namespace signorini::io
