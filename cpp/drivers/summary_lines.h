// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "io/manifest.h"

/// What a simulation tells at its end.
namespace signorini::drivers {

/// Contact and energy of the motion in words, line by line; none of what is not known.
std::vector<std::string> summary_lines(const io::Manifest& manifest);

/// Steps, seconds and bytes in words: "1500 steps in 0.2 s; …". `bytes`: of all files.
std::string cost_line(const io::Manifest& manifest, const scene::Scene& scene, const Timers& timers,
                      double bytes);

} // namespace signorini::drivers
