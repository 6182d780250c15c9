// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "accuracy/measured.h"

namespace signorini::accuracy {

constexpr const char* of_stress = "largest_von_mises"; ///< the name of that quantity

/// The quantities that can be compared in a scene: displacement, the largest von Mises stress, energy_loss
/// where it has contact with obstacles at rest, impulse, forces and times of contact, pressure where the
/// exact one is given, J and gradient with an objective. `dim` tells the units.
std::vector<Quantity> quantities(const scene::Scene& scene, int dim);

/// Those of these names or, if there are none, all but the gradient and, where the scene stores none, the
/// stress. Throws UserError.
std::vector<Quantity> chosen(const scene::Scene& scene, const std::vector<std::string>& names, int dim);

} // namespace signorini::accuracy
