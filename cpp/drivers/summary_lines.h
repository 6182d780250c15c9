// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "io/manifest.h"

/// Summary that a simulation prints at its end.
namespace signorini::drivers {

/// Lines on contact and energy of the motion; quantities that were not computed are omitted.
std::vector<std::string> summary_lines(const io::Manifest& manifest);

/// Line on the cost of a run, "1500 steps in 0.2 s; …". `bytes`: size of all files.
std::string cost_line(const io::Manifest& manifest, const scene::Scene& scene, const Timers& timers,
                      double bytes);

} // namespace signorini::drivers
