// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <array>
#include <string>
#include <vector>

namespace signorini::fem {

/// Speeds of pressure and shear waves in a material, m/s.
std::array<double, 2> wave_speeds(const scene::Material& material);

/// Time in which the fastest wave crosses the greatest extent of the undeformed body, s.
double crossing_time(const Space& space, const std::vector<scene::Material>& materials);

/// A surface, and the scene's key that names it.
struct Surface {
  std::string group, key;
};

/// Least time in which a pressure wave crosses an element, by its least height over the degree, s. Takes the
/// elements at `surfaces`, or all elements if there are none. Collective. Throws UserError.
double least_wave_time(const Space& space, const std::vector<scene::Material>& materials,
                       const std::vector<Surface>& surfaces);

} // namespace signorini::fem
