// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/space.h"
#include <array>
#include <string>
#include <vector>

namespace signorini::fem {

/// Speeds of pressure waves and of shear waves in a material, m/s; with the moduli at the instant of loading
/// if it relaxes. In plane stress pressure waves are those of a plate, √(E/(ρ (1 − ν²))).
std::array<double, 2> wave_speeds(const scene::Material& material, scene::PlaneModel model);

/// Time in which the fastest pressure wave crosses the longest side of the undeformed body's bounding box, s;
/// of several connected parts, that of the longest one. Collective.
double crossing_time(const Space& space, const std::vector<scene::Material>& materials);

/// Boundary group of facets, with the scene's key that names it.
struct Surface {
  std::string group, key;
};

/// Shortest time in which a pressure wave crosses an element, s: its least height divided by the degree and
/// by the wave speed. Considers the elements with a facet on `surfaces`, or all elements if `surfaces` is
/// empty. Collective. Throws UserError if a group is missing or unusable.
double least_wave_time(const Space& space, const std::vector<scene::Material>& materials,
                       const std::vector<Surface>& surfaces);

} // namespace signorini::fem
