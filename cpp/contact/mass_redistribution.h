// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "contact/pairs.h"

namespace signorini::contact {

/// For each of the scene's obstacles, whether its candidates lose their mass (contact.mass = "massless").
std::vector<bool> obstacles_without_mass(const std::vector<scene::Contact>& contacts);

/// Computes the mass matrix EᵀME of massless contact (docs/method.md section 2; Khenous, Laborde, Renard
/// 2008). E replaces the velocity of a contact node in the directions of its contact constraints by an
/// extrapolation from nodes that keep their mass. Contact nodes therefore carry no mass in these directions.
/// E reproduces velocity fields that are linear in space, so that the mass, its first moments and the moments
/// of inertia are unchanged. Where the nearby nodes do not suffice for this, E reproduces constant fields and
/// only the mass is unchanged. Candidates at which the boundary faces away from the obstacle cannot touch it
/// and keep their mass.
///
/// `massless`: for each of the scene's obstacles, whether its candidates lose their mass. The matrix is
/// stored in blocks (BAIJ), with the pattern of M and entries between the nodes used for extrapolation.
/// Collective. Throws UserError if no node near a candidate keeps its mass.
petsc::Matrix redistributed_mass(const fem::Space& space, const ContactPairs& pairs,
                                 const std::vector<bool>& massless, Mat M);

} // namespace signorini::contact
