// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/pairs.h"

namespace signorini::contact {

/// Whether each of a scene's obstacles removes the mass of its candidates.
std::vector<bool> obstacles_without_mass(const std::vector<scene::Contact>& contacts);

/// The mass matrix EᵀME of massless contact (docs/method.md section 2; Khenous, Laborde, Renard 2008). E
/// replaces the velocity of each contact node in the directions of its constraints by the extrapolation from
/// nodes within the body, so that contact nodes carry no mass in these directions. E preserves velocity
/// fields that are linear in space, and with them the mass, its first moments and the moments of inertia;
/// where too few nodes are near for that, only the mass. Candidates whose boundary faces away from the
/// obstacle keep their mass: they cannot touch it. `massless`: for each of the scene's obstacles,
/// whether its candidates lose their mass. The matrix is stored in blocks (BAIJ), with the pattern of M and
/// entries between the nodes extrapolated from. Collective. Throws UserError if all nodes near a candidate
/// are such contact nodes too.
petsc::Matrix redistributed_mass(const fem::Space& space, const ContactPairs& pairs,
                                 const std::vector<bool>& massless, Mat M);

} // namespace signorini::contact
