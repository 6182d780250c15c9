// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <array>
#include <string>
#include <vector>

namespace signorini::fem {

/// Speeds of pressure and shear waves in a material, m/s.
std::array<double, 2> wave_speeds(const scene::Material& material);

/// The time in which the fastest wave crosses the greatest extent of the undeformed body, s.
double crossing_time(const Space& space, const std::vector<scene::Material>& materials);

/// A surface, and the scene's key that names it.
struct Surface {
  std::string group, key;
};

/// The least time in which a pressure wave crosses an element, by its least height over the degree, s: of the
/// elements at some surfaces, of all where none is given. Collective. Throws UserError.
double least_wave_time(const Space& space, const std::vector<scene::Material>& materials,
                       const std::vector<Surface>& surfaces);

} // namespace signorini::fem
