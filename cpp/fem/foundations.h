// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "fem/forms.h"
#include "scene/choices.h"

namespace signorini::fem {

/// Assembles the springs of all foundations, Σ ∫ k_n (y·n)(φ·n) + k_t y_t·φ_t, in blocks (BAIJ); null if no
/// foundation has springs. Collective. Throws UserError unless the groups are surfaces.
petsc::Matrix assemble_springs(const Space& space, const std::vector<scene::Foundation>& foundations);

/// Assembles the dashpots of all foundations like assemble_springs(); null if no foundation has dashpots.
/// Absorbing foundations have c_n = ρ c_p and c_t = ρ c_s of the material at each facet (Lysmer and
/// Kuhlemeyer 1969). Collective. Throws UserError unless the groups are surfaces, absorbing ones parts of the
/// boundary.
petsc::Matrix assemble_dashpots(const Space& space, const std::vector<scene::Foundation>& foundations,
                                const std::vector<scene::Material>& materials);

/// Assembles the derivative of the springs or dashpots by one of the numbers of the foundation `number`: by
/// the number along the normal if `normal`, else by the one across it. Collective.
petsc::Matrix assemble_foundation_rate(const Space& space, const std::vector<scene::Foundation>& foundations,
                                       std::size_t number, bool normal);

/// Assembles the derivative of the absorbing dashpots by the constant `of` of the material with the number
/// `material`, in blocks (BAIJ); null if they do not depend on it, or without absorbing foundations.
/// Collective.
petsc::Matrix assemble_absorption_rate(const Space& space, const std::vector<scene::Foundation>& foundations,
                                       const std::vector<scene::Material>& materials, std::size_t material,
                                       scene::Parameter of);

} // namespace signorini::fem
